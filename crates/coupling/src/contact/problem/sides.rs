//! The sides of contacts, as points of bodies.

use crate::contact::system::CoupledSystem;
use crate::contact_point::{BodyRef, ContactPoint};
use rapunzel_contact::Body;
use rapunzel_rod_dynamic::Point;
use rayon::prelude::*;

/// A side of a contact: the number of the contact, and 0 or 1.
pub(super) type ContactSide = (usize, usize);

/// How all points of some bodies answer themselves, 1/kg.
pub(super) fn traces(bodies: &mut [&mut dyn Body]) -> Vec<f64> {
    let of_body = |body: &mut &mut dyn Body| {
        let mut traces = vec![0.0; body.points()];
        body.own_traces(&mut traces);
        traces
    };
    bodies.par_iter_mut().map(of_body).collect::<Vec<_>>().concat()
}

/// A side of a contact point that is a fibre, as a point of its group.
pub(super) fn rod_point(system: &CoupledSystem, point: &ContactPoint, side: usize) -> Point {
    let fiber = match point.sides[side] {
        BodyRef::Fiber(fiber) => system.fibers.lane(fiber as usize).1,
        BodyRef::Object(_) => 0,
    };
    let (segment, fraction, arm) = (point.segments[side], point.fractions[side], point.lever(side));
    #[expect(clippy::cast_possible_truncation, reason = "there are eight lanes")]
    Point { fiber: fiber as u32, segment, fraction, arm }
}

/// Something of every side, in lists as they are given.
pub(super) fn each<T: Send>(
    sides: &[Vec<ContactSide>],
    of_side: impl Fn(usize, usize) -> T + Sync,
) -> Vec<Vec<T>> {
    let list = |sides: &Vec<ContactSide>| sides.iter().map(|&(i, side)| of_side(i, side)).collect();
    sides.par_iter().map(list).collect()
}
