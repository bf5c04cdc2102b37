//! Which contacts of a long list can close at all.

use crate::body_ref::BodyRef;
use crate::contact::system::CoupledSystem;
use crate::contact_point::ContactPoint;
use crate::object::CollisionObject;
use nalgebra::Vector3;
use rapunzel_fiber::Layout;
use rayon::prelude::*;

/// The speed of a contact that may close wherever nodes go.
pub(super) const ALWAYS: f64 = f64::NEG_INFINITY;

/// How fast all contacts of a list open. Most of a dense list do, and go on to wherever their
/// fibres have not changed their velocities by as much: there they need not be looked at.
pub(super) struct ContactCulling {
    /// Velocities of all nodes with which contacts open so, m/s.
    nodes: Vec<Vector3<f64>>,
    /// By contact, m/s.
    speeds: Vec<f64>,
    /// The fibres of each; one more than there are for an object.
    fibers: Vec<[u32; 2]>,
}

impl ContactCulling {
    /// Touches open with these speeds, m/s, where all nodes have the given velocities.
    pub(super) fn new(
        system: &CoupledSystem,
        points: &[ContactPoint],
        speeds: Vec<f64>,
        nodes: &[Vector3<f64>],
    ) -> Self {
        let none = number(system.fibers.assembly().layout().fibers());
        let fiber = |side: BodyRef| match side {
            BodyRef::Fiber(fiber) => fiber,
            BodyRef::Object(_) => none,
        };
        let fibers = points.par_iter().map(|point| point.sides.map(fiber)).collect();
        let mut openings = Self { nodes: nodes.to_vec(), speeds, fibers };
        // How fast these are, nodes do not tell.
        if system.objects.iter().any(CollisionObject::is_free) {
            let is_free = |&i: &usize| points[i].has_free();
            let of_free: Vec<usize> = (0..points.len()).into_par_iter().filter(is_free).collect();
            openings.hold(&of_free);
        }
        openings
    }

    /// Lets some contacts be looked at always.
    pub(super) fn hold(&mut self, contacts: &[usize]) {
        contacts.iter().for_each(|&i| self.speeds[i] = ALWAYS);
    }

    /// Tells how fast contacts open where all nodes have the given velocities.
    pub(super) fn renew(
        &mut self,
        speeds: impl IndexedParallelIterator<Item = f64>,
        nodes: &[Vector3<f64>],
    ) {
        self.nodes.copy_from_slice(nodes);
        let all = self.speeds.par_iter_mut().zip(speeds);
        all.filter(|(old, _)| **old != ALWAYS).for_each(|(old, new)| *old = new);
    }

    /// The contacts that may close where all nodes have the given velocities, in their order: no
    /// other does.
    pub(super) fn near(&self, layout: &Layout, nodes: &[Vector3<f64>]) -> Vec<usize> {
        let change = |fiber: usize| {
            let range = layout.node_range(fiber);
            let both = nodes[range.clone()].iter().zip(&self.nodes[range]);
            both.map(|(now, then)| (now - then).norm_squared()).fold(0.0, f64::max).sqrt()
        };
        let mut changes: Vec<f64> = (0..layout.fibers()).into_par_iter().map(change).collect();
        changes.push(0.0);
        let near = |&i: &usize| {
            let [first, second] = self.fibers[i].map(|fiber| changes[fiber as usize]);
            self.speeds[i] <= first + second
        };
        (0..self.speeds.len()).into_par_iter().filter(near).collect()
    }
}

#[expect(clippy::cast_possible_truncation, reason = "nodes are counted with 32 bits")]
fn number(fiber: usize) -> u32 {
    fiber as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-1.0..1.0).prop_map(Vector3::from)
    }

    proptest! {
        /// Two fibres of two segments and something that does not move: whatever nodes do, no
        /// contact closes that is not told, and one that is always looked at is told always.
        #[test]
        fn none_closes_that_is_not_told(
            before in prop::collection::vec(vector(), 6),
            changes in prop::collection::vec(vector(), 6),
            scale in 0.0..1.0,
            points in prop::collection::vec((vector(), [0_usize..2, 0..2], [0.0..=1.0, 0.0..=1.0], 0_u32..3, 0.0..2.0), 1..20),
        ) {
            let layout = Layout::new([2, 2]);
            let after: Vec<_> = before.iter().zip(&changes).map(|(v, change)| v + scale * change).collect();
            let speed = |nodes: &[Vector3<f64>], i: usize| {
                let (normal, segments, fractions, second, gap) = &points[i];
                let at = |fiber: usize, side: usize| {
                    let node = layout.node_range(fiber).start + segments[side];
                    nodes[node].lerp(&nodes[node + 1], fractions[side])
                };
                let other = if *second < 2 { at(*second as usize, 1) } else { Vector3::zeros() };
                normal.normalize().dot(&(at(0, 0) - other)) + gap
            };
            let speeds: Vec<f64> = (0..points.len()).map(|i| speed(&before, i)).collect();
            let fibers = points.iter().map(|point| [0, point.3]).collect();
            let mut openings = ContactCulling { nodes: before.clone(), speeds, fibers };
            openings.hold(&[0]);
            let near = openings.near(&layout, &after);
            prop_assert_eq!(near[0], 0);
            prop_assert!(near.is_sorted());
            for i in (0..points.len()).filter(|i| !near.contains(i)) {
                prop_assert!(speed(&after, i) > -1e-12, "{}", i);
            }
            // At the same velocities only those that close are told.
            openings.renew((0..points.len()).into_par_iter().map(|i| speed(&after, i)), &after);
            for i in openings.near(&layout, &after).into_iter().skip(1) {
                prop_assert!(speed(&after, i) <= 0.0);
            }
        }
    }
}
