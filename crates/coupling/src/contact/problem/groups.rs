//! Which groups of fibres have sides of contacts.

use super::ContactProblem;
use super::sides::ContactSide;
use crate::body_ref::BodyRef;
use crate::contact::system::CoupledSystem;
use rayon::prelude::*;

/// Newton's method is done after an increment that is smaller than this, rad: the next is taken to
/// be of the order of the square. Of a falling lock it was the square, and 190 times that at worst,
/// where that was less than a third of what may stay.
pub(crate) const LAST_TURN: f64 = 1e-3;

impl ContactProblem {
    /// By group, whether it has sides of contacts that were solved last.
    pub(crate) fn working_groups(&self, system: &CoupledSystem) -> Vec<bool> {
        let mut working = vec![false; system.fibers.groups.len()];
        for side in self.working.iter().flat_map(|&i| self.points[i].sides) {
            if let BodyRef::Fiber(fiber) = side {
                working[system.fibers.lane(fiber as usize).0] = true;
            }
        }
        working
    }

    /// The sides of some contacts that move, by group of fibres and by object.
    pub(super) fn sides(
        &self,
        system: &CoupledSystem,
        contacts: &[usize],
    ) -> [Vec<Vec<ContactSide>>; 2] {
        let mut used = vec![Vec::new(); system.fibers.groups.len()];
        let mut on_objects = vec![Vec::new(); system.objects.len()];
        let moving = |&i: &usize| {
            let point = &self.points[i];
            [Some(point.sides[0]), (!point.kinematic).then_some(point.sides[1])]
        };
        let moving: Vec<_> = contacts.par_iter().map(moving).collect();
        for (&i, sides) in contacts.iter().zip(moving) {
            for (side, partner) in sides.into_iter().flatten().enumerate() {
                match partner {
                    BodyRef::Fiber(fiber) => {
                        used[system.fibers.lane(fiber as usize).0].push((i, side));
                    }
                    BodyRef::Object(object) => on_objects[object as usize].push((i, side)),
                }
            }
        }
        [used, on_objects]
    }
}
