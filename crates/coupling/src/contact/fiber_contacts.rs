//! Touches of fibres, of what is found of their segments.

use crate::body_ref::BodyRef;
use crate::contact_point::{ContactKey, ContactPoint};
use rapunzel_collision::{CapsuleContact, Capsules, Pair};
use rapunzel_fiber::Layout;
use rayon::prelude::*;

/// The contact points of all contacts, and others between them, both in order, in place of what a
/// list held.
pub(super) fn put_together(
    end: &Capsules,
    contacts: &[CapsuleContact],
    others: &[ContactPoint],
    points: &mut Vec<ContactPoint>,
) {
    let place = |(i, other): (usize, &ContactPoint)| {
        let rank = other.rank();
        i + contacts.partition_point(|contact| fiber_rank(end.layout(), contact) < rank)
    };
    let places: Vec<usize> = others.par_iter().enumerate().map(place).collect();
    let point = |i: usize| {
        let before = places.partition_point(|&place| place < i);
        let own = places.get(before) == Some(&i);
        if own { others[before] } else { fiber_touch(end, &contacts[i - before]) }
    };
    let count = contacts.len() + others.len();
    // Twice the room, as they would grow by, is much.
    points.clear();
    points.reserve_exact(count);
    (0..count).into_par_iter().map(point).collect_into_vec(points);
}

/// The fibres of two segments.
pub(super) fn fibers(layout: &Layout, pair: &Pair) -> [usize; 2] {
    pair.map(|segment| layout.segment_fibers()[segment as usize])
}

pub(super) fn same_fibers(layout: &Layout, a: &Pair, b: &Pair) -> bool {
    fibers(layout, a) == fibers(layout, b)
}

#[expect(clippy::cast_possible_truncation, reason = "nodes are counted with 32 bits")]
pub(super) fn fiber_number(fiber: usize) -> u32 {
    fiber as u32
}

/// The fibres of a contact, the one with the smaller number first, and the segments in them.
fn of_fibers(layout: &Layout, contact: &CapsuleContact) -> ([BodyRef; 2], [u32; 2]) {
    let fibers = fibers(layout, &contact.pair);
    let segment =
        |side: usize| contact.pair[side] - fiber_number(layout.segment_range(fibers[side]).start);
    (fibers.map(|fiber| BodyRef::Fiber(fiber_number(fiber))), [segment(0), segment(1)])
}

pub(super) fn fiber_rank(layout: &Layout, contact: &CapsuleContact) -> ContactKey {
    let (sides, segments) = of_fibers(layout, contact);
    ContactKey::new(sides, segments, contact.fractions)
}

fn fiber_touch(here: &Capsules, contact: &CapsuleContact) -> ContactPoint {
    let (sides, segments) = of_fibers(here.layout(), contact);
    let capsules = contact.pair.map(|segment| here.get(segment as usize));
    let [to_second, to_first] = [*contact.normal, -*contact.normal];
    ContactPoint {
        sides,
        segments,
        fractions: contact.fractions,
        normal: to_first,
        arms: capsules.map(|capsule| capsule.end - capsule.start),
        offsets: [capsules[0].radius * to_second, capsules[1].radius * to_first],
        gap: contact.gap,
        ..ContactPoint::IDLE
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;
    use rapunzel_collision::contacts_of_groups;

    /// Three fibres side by side of which all but one touch an object: what is put together is in
    /// order.
    #[test]
    fn others_are_put_between_contacts() {
        let layout = Layout::new([1, 1, 1]);
        let lines = [0.0, 1.0, 2.0].map(|y| [[0.0, y, 0.0], [1.0, y, 0.0]]);
        let positions = lines.as_flattened().iter().copied().map(Point3::from).collect::<Vec<_>>();
        let end = Capsules::new(&layout, &positions, &[0.5; 3]).expect("one layout");
        let mut contacts = Vec::new();
        let same = |_: &Pair, _: &Pair| false;
        let all = |found: &[CapsuleContact], stay: &mut Vec<CapsuleContact>| {
            stay.extend_from_slice(found);
        };
        contacts_of_groups(&end, &[[0, 1], [1, 2]], 0.1, same, all, &mut contacts)
            .expect("lengths");
        let of_object = |fiber: u32| ContactPoint {
            sides: [BodyRef::Fiber(fiber), BodyRef::Object(0)],
            ..fiber_touch(&end, &contacts[0])
        };
        let mut points = vec![of_object(1); 9];
        for others in [vec![], vec![of_object(0), of_object(2)]] {
            put_together(&end, &contacts, &others, &mut points);
            let mut expected: Vec<ContactPoint> =
                contacts.iter().map(|one| fiber_touch(&end, one)).collect();
            expected.extend(others);
            expected.sort_by_key(ContactPoint::rank);
            let ranks =
                |points: &[ContactPoint]| points.iter().map(ContactPoint::rank).collect::<Vec<_>>();
            assert!(contacts.len() > 2 && ranks(&points) == ranks(&expected), "{points:?}");
        }
        put_together(&end, &[], &[], &mut points);
        assert!(points.is_empty());
    }
}
