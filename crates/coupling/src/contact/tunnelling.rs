//! What fibres do on their way through a step: which would pass through each other, which have
//! changed sides, and which places where they seem to touch are none.

use super::fiber_contacts::fibers;
use crate::body_ref::BodyRef;
use crate::contact_point::ContactPoint;
use crate::merging::retain_others;
use nalgebra::Vector3;
use rapunzel_collision::continuous::{Impact, MovingSegment};
use rapunzel_collision::{CapsuleContact, Capsules, Pair};
use rayon::prelude::*;

/// Axes that come nearer to each other than this, in the sum of the radii, on the way would go on.
const INTO: f64 = 0.9;

/// Axes whose way is longer than their distance and that come nearer than this, in the sum of the
/// radii, may pass through each other; what goes less far does not, or is left deep in each other.
const THROUGH: f64 = 0.5;

/// Cosine of the angle to a normal from which on a segment leads towards the other side.
pub(super) const LEAN: f64 = 1e-3;

/// The gap along the normal of a contact between its places, m.
fn gap(end: &Capsules, contact: &CapsuleContact) -> f64 {
    let [first, second] = contact.pair.map(|segment| end.get(segment as usize));
    let [s, t] = contact.fractions;
    (second.at(t) - first.at(s)).dot(&contact.normal) - first.radius - second.radius
}

/// The largest squared way, m^2, of a point of one segment relative to one of the other.
pub(super) fn travel(start: &Capsules, end: &Capsules, pair: Pair) -> f64 {
    let ways = pair.map(|segment| {
        let nodes = start.layout().segment_nodes(segment as usize);
        nodes.map(|node| end.positions()[node] - start.positions()[node])
    });
    let squared = |i: usize, j: usize| (ways[0][i] - ways[1][j]).norm_squared();
    squared(0, 0).max(squared(0, 1)).max(squared(1, 0)).max(squared(1, 1))
}

/// When two axes first come as near as a part of the sum of the radii, and where.
fn impact(start: &Capsules, end: &Capsules, pair: Pair, part: f64) -> Option<Impact<2>> {
    let [i, j] = pair.map(|segment| segment as usize);
    let (a0, b0, a1, b1) = (start.get(i), start.get(j), end.get(i), end.get(j));
    let reach = a0.radius + b0.radius;
    let (a, b) = (MovingSegment::between(&a0, &a1), MovingSegment::between(&b0, &b1));
    a.impact(&b, part * reach, 1e-3 * reach)
}

/// Where two segments would pass through each other: the place of their impact, with the normal at
/// that time and the gap along it at the end. Surfaces are at least `inner` of the radii from
/// the axes.
pub(super) fn passing(
    start: &Capsules,
    end: &Capsules,
    pair: Pair,
    inner: f64,
) -> Option<CapsuleContact> {
    let impact = impact(start, end, pair, INTO * inner)?;
    let normal = nalgebra::Unit::try_new(impact.offset, 0.0)?;
    let contact = CapsuleContact { pair, fractions: impact.coordinates, normal, gap: 0.0 };
    Some(CapsuleContact { gap: gap(end, &contact), ..contact })
}

/// Whether a contact on the way is one of fibres that come so near that they may pass through each
/// other. Surfaces are at least `inner` of the radii from the axes.
pub(super) fn leads_through(
    start: &Capsules,
    end: &Capsules,
    contact: &CapsuleContact,
    inner: f64,
) -> bool {
    !bends(end, contact) && impact(start, end, contact.pair, THROUGH * inner).is_some()
}

/// Whether two places are so near along one fibre that not even the tightest bend, a half turn
/// about its own radius, lets them touch: what is between them is too short, and only straight
/// capsules overlap there.
pub(super) fn bends(end: &Capsules, contact: &CapsuleContact) -> bool {
    let layout = end.layout();
    let [first, second] = contact.pair.map(|segment| segment as usize);
    let [fiber, partner] = fibers(layout, &contact.pair);
    if fiber != partner {
        return false;
    }
    let length = |segment: usize| {
        let capsule = end.get(segment);
        (capsule.end - capsule.start).norm()
    };
    let [s, t] = contact.fractions;
    let reach = 0.5 * std::f64::consts::PI * (end.radii()[first] + end.radii()[second]);
    let mut between = (1.0 - s) * length(first) + t * length(second);
    for segment in first + 1..second {
        between += length(segment);
        if between > reach {
            return false;
        }
    }
    between < reach
}

/// Whether a contact is at a node where its fibre goes on towards the other one: the next segment
/// is nearer, and has the place. The normal of such a one leans along the fibre, which would catch
/// on each node of the other as it slides.
pub(super) fn goes_on(end: &Capsules, contact: &CapsuleContact) -> bool {
    let (layout, nodes) = (end.layout(), end.positions());
    [0, 1].into_iter().any(|side| {
        let segment = contact.pair[side] as usize;
        let segments = layout.segment_range(layout.segment_fibers()[segment]);
        let [root, tip] = layout.segment_nodes(segment);
        let [before, node, next] = match contact.fractions[side] {
            0.0 if segment > segments.start => [tip, root, root - 1],
            1.0 if segment + 1 < segments.end => [root, tip, tip + 1],
            _ => return false,
        };
        let towards = if side == 0 { *contact.normal } else { -*contact.normal };
        let leads = |way: Vector3<f64>| {
            let along = way.dot(&towards);
            along > 0.0 && along * along > LEAN * LEAN * way.norm_squared()
        };
        leads(nodes[node] - nodes[before]) && leads(nodes[next] - nodes[node])
    })
}

/// Whether the places of a contact point of fibres were on the other side of each other at the
/// start.
fn turned(start: &Capsules, point: &ContactPoint) -> bool {
    let [BodyRef::Fiber(fiber), BodyRef::Fiber(partner)] = point.sides else { return false };
    let [s, t] = point.segments;
    let at = |fiber: u32, segment: u32, fraction: f64| {
        let first = start.layout().segment_range(fiber as usize).start;
        start.get(first + segment as usize).at(fraction)
    };
    let own = at(fiber, s, point.fractions[0]);
    (own - at(partner, t, point.fractions[1])).dot(&point.normal) < 0.0
}

/// Drops the contact points that have turned to the other side beside one of their pair that has
/// not. About a bend one segment may meet a fibre that its neighbor would pass through, and find it
/// on its far side: between the two normals the fibre could not move at all. Touches are sorted by
/// pair.
pub(super) fn keep_sides(start: &Capsules, points: &mut Vec<ContactPoint>) {
    let turned: Vec<bool> = points.par_iter().map(|point| turned(start, point)).collect();
    let jams = |i: usize| {
        let pair = points[i].sides;
        let first = points.partition_point(|point| point.sides < pair);
        let from_first = points[first..].iter().zip(&turned[first..]);
        let mut of_pair = from_first.take_while(|(point, _)| point.sides == pair);
        of_pair.any(|(point, turned)| !turned && point.opposes(&points[i]))
    };
    let jammed = (0..points.len()).into_par_iter().map(|i| turned[i] && jams(i)).collect();
    retain_others(points, jammed);
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;
    use proptest::prelude::*;
    use rapunzel_fiber::Layout;

    proptest! {
        /// Of contact points of three fibres that cross each other, with normals up or down, those
        /// go that have turned beside one of their pair that has not; two that both have stay.
        #[test]
        fn touches_that_jam_others_go(
            mut all in prop::collection::vec((0..2_u32, 0..8_u32, any::<bool>()), 0..20),
        ) {
            const SEGMENTS: usize = 4;
            all.sort_by_key(|&(fiber, place, _)| (fiber, place));
            let layout = Layout::new([SEGMENTS; 3]);
            const CROSSING: f64 = 1.9;
            let node = |i: usize| {
                let (fiber, x) = (i / (SEGMENTS + 1), (i % (SEGMENTS + 1)) as f64);
                [x, 0.0, fiber as f64 * (x - CROSSING)]
            };
            let nodes: Vec<_> = (0..layout.nodes()).map(|i| Point3::from(node(i))).collect();
            let radii = vec![0.4; layout.segments()];
            let start = Capsules::new(&layout, &nodes, &radii).expect("one layout");
            let point = |&(fiber, place, up): &(u32, u32, bool)| ContactPoint {
                sides: [fiber, fiber + 1].map(BodyRef::Fiber),
                segments: [place / 2; 2],
                fractions: [0.5 * f64::from(place % 2); 2],
                normal: Vector3::z() * if up { 1.0 } else { -1.0 },
                arms: [Vector3::x(); 2],
                offsets: [Vector3::zeros(); 2],
                gap: 0.2,
                ..ContactPoint::IDLE
            };
            let mut points: Vec<_> = all.iter().map(point).collect();
            keep_sides(&start, &mut points);
            let turned = |&(_, place, up): &(u32, u32, bool)| up == (0.5 * f64::from(place) > CROSSING);
            let jams = |one: &(u32, u32, bool)| {
                // Within less than a segment.
                let beside = |other: &(u32, u32, bool)| {
                    other.0 == one.0 && other.1.abs_diff(one.1) < 2 && other.2 != one.2
                };
                turned(one) && all.iter().any(|other| beside(other) && !turned(other))
            };
            let expected: Vec<_> = all.iter().filter(|one| !jams(one)).map(point).collect();
            let told = |points: &[ContactPoint]| -> Vec<_> {
                points.iter().map(|one| (one.sides, one.at(), one.normal.z)).collect()
            };
            prop_assert_eq!(told(&points), told(&expected));
        }
    }
}
