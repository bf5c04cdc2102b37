//! What fibres do on their way through a step: which would pass through each other, which have changed sides, and
//! which places where they seem to touch are none.

use super::fiber_touch::fibers;
use super::touch::{Partner, Touch, retain_others};
use nalgebra::Vector3;
use rapunzel_collision::continuous::{Impact, MovingSegment};
use rapunzel_collision::{Capsules, Contact, Pair};
use rayon::prelude::*;

/// Axes that come nearer to each other than this, in the sum of the radii, on the way would go on.
const INTO: f64 = 0.9;

/// Axes whose way is longer than their distance and that come nearer than this, in the sum of the radii,
/// may pass through each other; what goes less far does not, or is left deep in each other.
const THROUGH: f64 = 0.5;

/// Cosine of the angle to a normal from which on a segment leads towards the other side.
pub(super) const LEAN: f64 = 1e-3;

/// The gap along the normal of a contact between its places, m.
fn gap(end: &Capsules, contact: &Contact) -> f64 {
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
/// that time and the gap along it at the end.
pub(super) fn passing(start: &Capsules, end: &Capsules, pair: Pair) -> Option<Contact> {
    let impact = impact(start, end, pair, INTO)?;
    let normal = nalgebra::Unit::try_new(impact.offset, 0.0)?;
    let contact = Contact { pair, fractions: impact.coordinates, normal, gap: 0.0 };
    Some(Contact { gap: gap(end, &contact), ..contact })
}

/// Whether a contact on the way is one of fibres that come so near that they may pass through each other.
pub(super) fn leads_through(start: &Capsules, end: &Capsules, contact: &Contact) -> bool {
    !bends(end, contact) && impact(start, end, contact.pair, THROUGH).is_some()
}

/// Whether two places are so near along one fibre that not even the tightest bend, a half turn about
/// its own radius, lets them touch: what is between them is too short, and only straight capsules
/// overlap there.
pub(super) fn bends(end: &Capsules, contact: &Contact) -> bool {
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

/// Whether a contact is at a node where its fibre goes on towards the other one: the next segment is nearer,
/// and has the place. The normal of such a one leans along the fibre, which would catch on each node of the other
/// as it slides.
pub(super) fn goes_on(end: &Capsules, contact: &Contact) -> bool {
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

/// Whether the places of a touch of fibres were on the other side of each other at the start.
fn turned(start: &Capsules, touch: &Touch) -> bool {
    let [Partner::Fiber(fiber), Partner::Fiber(partner)] = touch.sides else { return false };
    let [s, t] = touch.segments;
    let at = |fiber: u32, segment: u32, fraction: f64| {
        let first = start.layout().segment_range(fiber as usize).start;
        start.get(first + segment as usize).at(fraction)
    };
    let own = at(fiber, s, touch.fractions[0]);
    (own - at(partner, t, touch.fractions[1])).dot(&touch.normal) < 0.0
}

/// Drops the touches that have turned to the other side beside one of their pair that has not. About
/// a bend one segment may meet a fibre that its neighbor would pass through, and find it on its far
/// side: between the two normals the fibre could not move at all. Touches are sorted by pair.
pub(super) fn keep_sides(start: &Capsules, touches: &mut Vec<Touch>) {
    let jammed = |group: &[Touch]| {
        let turned: Vec<_> = group.iter().map(|touch| turned(start, touch)).collect();
        let stays = |i: usize| !turned[i];
        let jams = |i: usize| {
            (0..group.len()).any(|other| stays(other) && group[other].opposes(&group[i]))
        };
        (0..group.len()).map(|i| turned[i] && jams(i)).collect::<Vec<_>>()
    };
    let jammed: Vec<_> =
        touches.par_chunk_by(|a, b| a.sides == b.sides).flat_map_iter(jammed).collect();
    retain_others(touches, jammed);
}
