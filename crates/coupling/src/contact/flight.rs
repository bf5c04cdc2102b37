//! Which fibres fly: those near nothing move by a method of second order, the others by backward
//! Euler, with which contacts come to rest.

use super::ball_joints::BallJoints;
use super::system::CoupledSystem;
use crate::body_ref::BodyRef;
use crate::contact_point::ContactPoint;

impl CoupledSystem<'_> {
    /// Notes fibres that are sides of contact points or joints as `touching`, and lets those that
    /// fly bear them from where a substep sets out on. Returns by group whether it has none of
    /// these, or nothing where no group has any.
    pub(super) fn land(
        &mut self,
        touching: &mut [bool],
        points: &[ContactPoint],
        joints: &BallJoints,
    ) -> Option<Vec<bool>> {
        for side in points.iter().flat_map(|point| point.sides).chain(joints.sides()) {
            if let BodyRef::Fiber(fiber) = side {
                touching[fiber as usize] = true;
            }
        }
        let groups = self.fibers.groups.iter_mut();
        let others: Vec<bool> = groups.map(|group| !group.land(|fiber| touching[fiber])).collect();
        others.contains(&false).then_some(others)
    }

    /// Lets fibres that are not `touching` fly from the next substep on.
    pub(super) fn take_off(&mut self, touching: &[bool]) {
        self.fibers.groups.iter_mut().for_each(|group| group.take_off(|fiber| touching[fiber]));
    }
}
