//! Which fibres grow out of which objects.

use super::fiber_contacts::fiber_number;
use super::node_motion::NodeMotion;
use crate::object::CollisionObject;

/// Part of the height of a chord's ends on a round object below which a root is too low for it. A
/// segment that was pried off by a root that is clamped there would carry no friction.
const LOW_ROOT: f64 = 0.5;

/// Fibres that grow out of kinematic objects, and these, by their numbers, in order: those whose
/// root at the start of a motion has a gap to an object below what `grows` tells of the fibre, m,
/// or too small for a chord to lie on the object from there. Nothing tells of roots that are not
/// held.
pub(super) fn rooted(
    motion: &NodeMotion,
    objects: &[CollisionObject],
    grows: impl Fn(usize) -> Option<f64>,
) -> Vec<[u32; 2]> {
    let fibers = (0..motion.layout.fibers()).filter_map(|fiber| Some((fiber, grows(fiber)?)));
    let pairs = fibers.flat_map(|(fiber, gap)| {
        let node = motion.layout.node_range(fiber).start;
        let [root, next] = [node, node + 1].map(|node| motion.start[node]);
        let first = motion.layout.segment_range(fiber).start;
        let height = motion.sections.shapes.height(first);
        let is_in = move |object: &CollisionObject| {
            let pose = object.pose(motion.step.start);
            let value = |node| object.field().value(&pose.inverse_transform_point(&node));
            let above = value(root) - height;
            // Over half a segment to both sides the surface falls off by as much as a chord
            // has to lie above it at its ends.
            let lies_too_low = || {
                let half = 0.5 * (next - root);
                let sagitta = 0.5 * (value(root + half) + value(root - half)) - value(root);
                sagitta < height && above < LOW_ROOT * sagitta
            };
            !object.is_free() && (above < gap || above < LOW_ROOT * height && lies_too_low())
        };
        let objects = (0..).zip(objects).filter(move |(_, object)| is_in(object));
        objects.map(move |(object, _)| [fiber_number(fiber), object])
    });
    pairs.collect()
}
