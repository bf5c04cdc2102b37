//! Which fibres fly: those near nothing move by a method of second order, the others by backward
//! Euler, with which contacts come to rest.

use super::ball_joints::BallJoints;
use super::system::CoupledSystem;
use crate::body_ref::BodyRef;
use crate::contact_point::ContactPoint;

/// Whether each fibre is a side of any of some contact points or joints.
fn touching(fibers: usize, points: &[ContactPoint], joints: &BallJoints) -> Vec<bool> {
    let mut touching = vec![false; fibers];
    for side in points.iter().flat_map(|point| point.sides).chain(joints.sides()) {
        if let BodyRef::Fiber(fiber) = side {
            touching[fiber as usize] = true;
        }
    }
    touching
}

impl CoupledSystem<'_> {
    /// Lets fibres that fly and are sides of contact points or joints bear them from the next
    /// substep on. Returns whether there are any: the substep under way has to be set out anew.
    pub(super) fn land(&mut self, points: &[ContactPoint], joints: &BallJoints) -> bool {
        let touching = touching(self.fibers.assembly().fibers().len(), points, joints);
        let groups = self.fibers.groups.iter_mut();
        groups.fold(false, |any, group| group.land(|fiber| touching[fiber]) | any)
    }

    /// Lets fibres that are sides of no contact point and no joint fly from the next substep on.
    pub(super) fn take_off(&mut self, points: &[ContactPoint], joints: &BallJoints) {
        let touching = touching(self.fibers.assembly().fibers().len(), points, joints);
        self.fibers.groups.iter_mut().for_each(|group| group.take_off(|f| touching[f]));
    }
}
