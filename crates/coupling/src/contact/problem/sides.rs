//! The sides of contacts, and the groups of fibres that have them.

use super::ContactProblem;
use crate::contact::newton::LAST_TURN;
use crate::contact::system::CoupledSystem;
use crate::contact_point::{BodyRef, ContactPoint};
use rapunzel_contact::Body;
use rapunzel_rod_dynamic::Point;
use rayon::prelude::*;

/// A side of a contact: the number of the contact, and 0 or 1.
pub(super) type ContactSide = (usize, usize);

impl ContactProblem {
    /// By group, whether it has no contact in the list and its last increment, `turns`, rad, was so
    /// small that it is solved: what others do does not move it.
    pub(crate) fn still(&self, system: &CoupledSystem, turns: &[f64]) -> Vec<bool> {
        let mut still: Vec<bool> = turns.iter().map(|turn| *turn < LAST_TURN).collect();
        for side in self.points.iter().flat_map(|point| point.sides) {
            if let BodyRef::Fiber(fiber) = side {
                still[system.fibers.lane(fiber as usize).0] = false;
            }
        }
        still
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
