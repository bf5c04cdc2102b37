//! Contacts that push at a place, and those that are couples, as points of bodies.

use super::ContactProblem;
use crate::body_ref::BodyRef;
use crate::contact::junctions::Couple;
use crate::contact::system::CoupledSystem;
use crate::contact::velocities::Velocities;
use nalgebra::Vector3;
use rapunzel_rod_dynamic::{Point, PointAction};

impl ContactProblem {
    /// The couple that a contact is; `None` of those that push.
    pub(super) fn couple(&self, i: usize) -> Option<&Couple> {
        let first = self.points.len() - self.couples.len();
        self.couples.get(i.checked_sub(first)?)
    }

    /// A side of a contact that is a fibre, as a point of its group.
    pub(super) fn rod_point(&self, system: &CoupledSystem, i: usize, side: usize) -> Point {
        let point = &self.points[i];
        let fiber = match point.sides[side] {
            BodyRef::Fiber(fiber) => system.fibers.lane(fiber as usize).1,
            BodyRef::Object(_) => 0,
        };
        let segment = point.segments[side];
        let action = match self.couple(i) {
            Some(&Couple { lever, .. }) => PointAction::Couple { lever },
            None => {
                let (fraction, arm) = (point.fractions[side], point.lever(side));
                PointAction::Force { fraction, arm }
            }
        };
        #[expect(clippy::cast_possible_truncation, reason = "there are eight lanes")]
        Point { fiber: fiber as u32, segment, action }
    }

    /// Velocity of a side of a contact, m/s; zero for an object with a given motion.
    pub(super) fn of_side(&self, i: usize, side: usize, all: &Velocities) -> Vector3<f64> {
        match self.couple(i) {
            None => all.of_side(&self.points[i], side),
            Some(Couple { lever, .. }) => lever.tr_mul(&all.spin_of_side(&self.points[i], side)),
        }
    }

    /// Velocity of the first side of a contact as seen from the second, m/s.
    pub(super) fn between(&self, i: usize, all: &Velocities) -> Vector3<f64> {
        self.of_side(i, 0, all) - self.of_side(i, 1, all)
    }

    /// Takes the law of what bends at joints where all fibres have the given mean velocities over a
    /// step; `moments` are those of the impulses that it bears there, N m s, world.
    pub(in crate::contact) fn bend(&mut self, all: &Velocities, moments: &[Vector3<f64>]) {
        let first = self.points.len() - self.couples.len();
        for (i, moment) in (first..).zip(moments) {
            let Some(Couple { inverse, compliance, .. }) = self.couple(i) else { continue };
            let bias = -self.between(i, all) - inverse * moment * *compliance;
            self.laws[i].bias = self.points[i].frame().tr_mul(&bias);
        }
    }
}
