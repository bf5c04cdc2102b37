//! What bends between fibres that are joined and may touch: couples of the solver.
//!
//! A couple turns two segments against each other. Its law is elastic: where the step ends, the
//! moment is that of the junction there. To the solver that is a joint that gives way. Of an
//! impulse `q` the moment is `S q` with a lever `S`, and the velocity is `S^T` times the angular
//! velocity of the first segment as seen from the second: by `S S^T / (c dt^2)`, the elastic part
//! of the second derivative of the energy, the junction gives way alike to all `q`, by the
//! compliance `c`. The rest of the law is in the bias, which is taken anew after each increment.

use super::system::CoupledSystem;
use crate::Fibers;
use crate::NodeJoint;
use crate::body_ref::BodyRef;
use crate::contact_point::{ContactImpulse, ContactPoint};
use crate::joints::Junction;
use nalgebra::{Matrix3, SymmetricEigen, UnitQuaternion, Vector3};
use rapunzel_rod_dynamic::{Ledger, StaggeredBatch};

/// What bends at one joint.
#[derive(Debug)]
struct ContactJunction {
    /// Fibres, and the segments of them.
    fibers: [usize; 2],
    segments: [usize; 2],
    junction: Junction,
    /// The matrix of which its stiffness is the square, and the inverse of that.
    roots: [Matrix3<f64>; 2],
    /// Its mean stiffness, N m.
    stiffness: f64,
    /// Length by which couples are measured, m: that of a segment.
    length: f64,
}

/// What bends at all joints.
#[derive(Debug, Default)]
pub(super) struct ContactJunctions {
    all: Vec<ContactJunction>,
    /// Rotation vectors at the start of the step under way, rad.
    before: Vec<Vector3<f64>>,
}

/// A couple in a problem of contacts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Couple {
    /// Moment of impulse by impulse, m, world.
    pub(super) lever: Matrix3<f64>,
    /// The inverse of the lever, 1/m.
    pub(super) inverse: Matrix3<f64>,
    /// By how much it gives way, 1/kg.
    pub(super) compliance: f64,
}

impl ContactJunctions {
    /// What bends at joints, in their order; balls have nothing that does.
    pub(super) fn new(joints: &[NodeJoint], system: &CoupledSystem) -> Self {
        let assembly = system.fibers.assembly();
        let one = |joint: &NodeJoint| {
            let (fibers, segments) =
                (joint.places.map(|place| place.fiber), joint.places.map(|place| place.segment()));
            let junction = Junction::new(joint, assembly, frames(system.fibers, fibers, segments))?;
            let SymmetricEigen { eigenvectors, eigenvalues } = junction.stiffness.symmetric_eigen();
            let roots = [0.5, -0.5].map(|power| {
                let scaled = Matrix3::from_diagonal(&eigenvalues.map(|k| k.powf(power)));
                eigenvectors * scaled * eigenvectors.transpose()
            });
            let length = assembly.fibers()[fibers[0]].segment_lengths()[segments[0]];
            let stiffness = junction.stiffness.trace() / 3.0;
            Some(ContactJunction { fibers, segments, junction, roots, stiffness, length })
        };
        Self { all: joints.iter().filter_map(one).collect(), before: Vec::new() }
    }

    /// Whether nothing bends.
    pub(super) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Notes where a step sets out from.
    pub(super) fn set_out(&mut self, fibers: &Fibers<StaggeredBatch>) {
        self.before = self.turns(fibers);
    }

    /// Rotation vectors where fibres are, rad.
    fn turns(&self, fibers: &Fibers<StaggeredBatch>) -> Vec<Vector3<f64>> {
        self.all.iter().map(|one| one.junction.turn(one.frames(fibers))).collect()
    }

    /// Elastic energy where fibres are, J.
    pub(super) fn stored(&self, fibers: &Fibers<StaggeredBatch>) -> f64 {
        let turns = self.turns(fibers);
        self.all.iter().zip(&turns).map(|(one, turn)| one.junction.stored(turn)).sum()
    }

    /// The couples of a step of `dt` seconds, where it has been solved to so far, each at a contact
    /// point that bears its part of some moments of impulses on first sides, N m s, world.
    pub(super) fn points(
        &self,
        fibers: &Fibers<StaggeredBatch>,
        dt: f64,
        moments: &[Vector3<f64>],
    ) -> Vec<(ContactPoint, Couple)> {
        let each = self.all.iter().zip(moments);
        each.map(|(one, moment)| {
            let couple = one.couple(fibers, dt);
            (one.point(couple.inverse * moment), couple)
        })
        .collect()
    }

    /// Moments of impulses that junctions bear in a step of `dt` seconds that ends where it has
    /// been solved to so far, on their first sides, N m s, world.
    pub(super) fn moments(&self, fibers: &Fibers<StaggeredBatch>, dt: f64) -> Vec<Vector3<f64>> {
        let each = self.all.iter().zip(&self.before);
        each.map(|(one, before)| dt * one.junction.act(one.frames(fibers), before, dt).moment)
            .collect()
    }

    /// What moments of impulses on first sides do, N m s, world.
    pub(super) fn pushes<'a>(
        &'a self,
        moments: &'a [Vector3<f64>],
    ) -> impl Iterator<Item = ContactImpulse> + 'a {
        let each = self.all.iter().zip(moments);
        each.map(|(one, moment)| ContactImpulse {
            couple: true,
            ..one.point(Vector3::zeros()).push(*moment)
        })
    }

    /// Works in a step of `dt` seconds that has been solved, in which couples have done the given
    /// work on fibres, J: what of it is not stored has been damped, or lost by the method.
    pub(super) fn works(&self, fibers: &Fibers<StaggeredBatch>, work: f64, dt: f64) -> Ledger {
        let mut works = Ledger { integrator: work, ..Ledger::default() };
        for ((one, before), after) in self.all.iter().zip(&self.before).zip(self.turns(fibers)) {
            let junction = &one.junction;
            let damped = junction.damped([before, &after], dt);
            works.damping += damped;
            works.integrator += junction.stored(&after) - junction.stored(before) - damped;
        }
        works
    }
}

impl ContactJunction {
    fn frames(&self, fibers: &Fibers<StaggeredBatch>) -> [UnitQuaternion<f64>; 2] {
        frames(fibers, self.fibers, self.segments)
    }

    /// The couple of a step of `dt` seconds, where it has been solved to so far.
    fn couple(&self, fibers: &Fibers<StaggeredBatch>, dt: f64) -> Couple {
        let Self { junction, stiffness, length, .. } = self;
        let frames = self.frames(fibers);
        let scale = length / stiffness.sqrt();
        let lever = scale * junction.elastic_root(&self.roots[0], frames);
        let resists = stiffness * (1.0 + junction.damping / dt);
        let compliance = length * length / (resists * dt * dt);
        let inverse = lever.try_inverse().unwrap_or_else(Matrix3::zeros);
        Couple { lever, inverse, compliance }
    }

    /// Where it acts, with an impulse on the first side, N s.
    #[expect(clippy::cast_possible_truncation, reason = "fibres are counted with 32 bits")]
    fn point(&self, impulse: Vector3<f64>) -> ContactPoint {
        ContactPoint {
            sides: self.fibers.map(|fiber| BodyRef::Fiber(fiber as u32)),
            segments: self.segments.map(|segment| segment as u32),
            fractions: [0.5; 2],
            normal: Vector3::x(),
            arms: [Vector3::zeros(); 2],
            offsets: [Vector3::zeros(); 2],
            gap: 0.0,
            impulse,
            ..ContactPoint::IDLE
        }
    }
}

/// Frames of segments of two fibres.
fn frames(
    fibers: &Fibers<StaggeredBatch>,
    pair: [usize; 2],
    segments: [usize; 2],
) -> [UnitQuaternion<f64>; 2] {
    [0, 1].map(|i| {
        let (group, lane) = fibers.lane(pair[i]);
        fibers.groups[group].batch.frame(lane, segments[i])
    })
}
