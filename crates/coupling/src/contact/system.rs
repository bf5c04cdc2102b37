use crate::body_ref::BodyRef;
use crate::contact_point::ContactImpulse;
use crate::free_body::moved;
use crate::object::{CollisionObject, ObjectMotion};
use crate::{Fibers, Surroundings};
use nalgebra::{Vector3, Vector6};
use rapunzel_contact::{ContactError, RigidPoints};
use rapunzel_rod_dynamic::{Ledger, StaggeredBatch, segments_in_nozzle};
use rapunzel_scene::Environment;
use rayon::prelude::*;

/// Fibres and objects while a step of both is solved.
pub(super) struct CoupledSystem<'a> {
    pub(super) fibers: &'a mut Fibers<StaggeredBatch>,
    pub(super) objects: &'a mut [CollisionObject],
    pub(super) environment: &'a Environment,
    /// Start of the step, s.
    pub(super) start: f64,
}

impl<'a> CoupledSystem<'a> {
    pub(super) fn new(
        fibers: &'a mut Fibers<StaggeredBatch>,
        around: &'a mut Surroundings,
    ) -> Self {
        let Surroundings { environment, objects, start, .. } = around;
        Self { fibers, objects, environment, start: *start }
    }

    /// Kinetic energy of all fibres and free objects at the start of the step, J.
    pub(super) fn kinetic_energy(&self) -> f64 {
        let gravity = self.environment.gravity_at(self.start);
        let fibers = self.fibers.energy(&gravity).kinetic;
        let free = self.objects.iter().filter_map(|object| object.energy(&gravity));
        free.fold(fibers, |sum, energy| sum + energy.kinetic)
    }

    /// Number of segments of each fibre that are inside a nozzle at time `t`, s; empty where no
    /// fibre is fed.
    pub(super) fn in_nozzles(&self, t: f64) -> Vec<usize> {
        let lanes =
            || self.fibers.groups.iter().flat_map(|group| group.fibers.iter().zip(&group.lanes));
        if !lanes().any(|(_, lane)| lane.is_fed()) {
            return Vec::new();
        }
        let fibers = self.fibers.assembly().fibers();
        let mut all = vec![0; fibers.len()];
        for (&fiber, lane) in lanes() {
            all[fiber] = segments_in_nozzle(fibers[fiber].segment_lengths(), lane.inside(t));
        }
        all
    }

    /// Makes the step from `time` by `dt`, s, that has been solved the state of all groups and
    /// objects, and records it with the works of joints.
    pub(super) fn accept(&mut self, time: f64, dt: f64, joints: &Ledger) {
        self.fibers.groups.par_iter_mut().for_each(|group| group.batch.accept());
        let mut works = self.accept_bodies(time, dt);
        works += *joints;
        self.fibers.record(&works);
    }

    /// Takes all groups back to before the step.
    pub(super) fn abandon(&mut self) {
        self.fibers.groups.par_iter_mut().for_each(|group| group.batch.abandon());
    }
}

impl CoupledSystem<'_> {
    /// Solves the step from `time` by `dt`, s, of all free bodies with the impulses of some
    /// touches.
    pub(super) fn push(
        &mut self,
        pushes: impl Iterator<Item = ContactImpulse>,
        time: f64,
        dt: f64,
    ) -> Result<(), ContactError> {
        if !self.objects.iter().any(CollisionObject::is_free) {
            return Ok(());
        }
        let mut wrenches = vec![Vector6::zeros(); self.objects.len()];
        for push in pushes {
            for (side, impulse) in [push.impulse, -push.impulse].into_iter().enumerate() {
                let BodyRef::Object(object) = push.sides[side] else { continue };
                let moment = push.levers[side].cross(&impulse);
                let wrench = &mut wrenches[object as usize];
                *wrench += Vector6::from_iterator(impulse.iter().chain(&moment).copied());
            }
        }
        let gravity = self.environment.gravity_at(time + 0.5 * dt);
        for (object, wrench) in self.objects.iter_mut().zip(&wrenches) {
            if let ObjectMotion::Dynamic(body) = &mut object.motion {
                body.solved = moved(&body.state, wrench, dt, &gravity)?;
            }
        }
        Ok(())
    }

    /// Makes the step from `time` by `dt`, s, that has been solved the state of all free bodies,
    /// and returns what gravity and the integrator did to them.
    pub(super) fn accept_bodies(&mut self, time: f64, dt: f64) -> Ledger {
        let gravity = self.environment.gravity_at(time + 0.5 * dt);
        let mut sum = Ledger::default();
        for object in self.objects.iter_mut() {
            if let ObjectMotion::Dynamic(body) = &mut object.motion {
                sum += body.works(&gravity);
                body.state = body.solved.clone();
            }
        }
        sum
    }

    /// All free bodies as a solver sees them, touched at levers from their centers of mass.
    pub(super) fn free_bodies(
        &self,
        levers: &[Vec<Vector3<f64>>],
    ) -> Result<Vec<RigidPoints>, ContactError> {
        let mut bodies = Vec::new();
        for (object, levers) in self.objects.iter().zip(levers) {
            if let ObjectMotion::Dynamic(body) = &object.motion {
                let center = body.state.center();
                let points: Vec<_> = levers.iter().map(|lever| center + lever).collect();
                bodies.push(body.state.with_points(&points)?);
            }
        }
        Ok(bodies)
    }
}
