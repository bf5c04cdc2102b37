//! What the contacts of a step do where all fibres have given velocities.

use super::ContactProblem;
use crate::contact::contact_work::ContactWork;
use crate::contact::node_arrays::FiberVelocities;
use crate::contact::system::CoupledSystem;
use crate::contact::velocities::Velocities;
use crate::contact_point::ContactPoint;
use crate::contact_report::Unresolved;
use nalgebra::Vector3;
use rapunzel_contact::{Bond, Contact, ContactError, ErrorMasses, Report, Violation, report};
use rapunzel_rod_dynamic::StepVelocity;
use rayon::prelude::*;
use std::ops::AddAssign;

/// Contacts that one task takes.
const RESIDUAL_CHUNK: usize = 1024;

/// The part of the kinetic energy that contacts may give in a step, for want of shorter ones.
const MUCH: f64 = 0.1;

impl ContactProblem {
    /// Number of contacts that bear something, without joints.
    pub(crate) fn active(&self) -> usize {
        self.working.par_iter().filter(|&&i| i < self.listed && self.bears(i)).count()
    }

    fn bears(&self, contact: usize) -> bool {
        self.impulses[contact] != Vector3::zeros()
    }

    /// How well the law holds where all fibres have the given mean velocities.
    pub(crate) fn certificate(&self, system: &CoupledSystem, mean: &FiberVelocities) -> Report {
        let near = self.near_where(system, &mean.nodes);
        let mean = Velocities::new(system, mean);
        // What opens and bears nothing is right.
        let acting: Vec<usize> = near.into_par_iter().filter(|&i| self.acts(i, &mean)).collect();
        report(acting.len(), |k| self.judged(acting[k], &mean))
    }

    /// The contact that is farthest from the law in the substep that starts at `time`, s, where
    /// the rods are.
    pub(crate) fn worst(&self, system: &CoupledSystem, time: f64) -> Option<Unresolved> {
        let mean = self.velocities(system, StepVelocity::Mean);
        let mean = Velocities::new(system, &mean);
        let wrong = |i: usize| {
            let (contact, velocity, impulse, ErrorMasses { own, moved }) = self.judged(i, &mean);
            Violation::new(&contact, &velocity, &impulse, own).impulse * (moved / own)
        };
        let worst = (0..self.laws.len()).max_by(|&i, &j| wrong(i).total_cmp(&wrong(j)))?;
        Some(Unresolved::new(time, &self.points[worst]))
    }

    /// A contact with its relative velocity, what gives way included, its impulse and the masses
    /// that compare them.
    fn judged(
        &self,
        i: usize,
        mean: &Velocities,
    ) -> (Contact, Vector3<f64>, Vector3<f64>, ErrorMasses) {
        let point = &self.points[i];
        let contact = self.laws[i].contact(point, [0, 1]);
        let impulse = self.impulses[i];
        let velocity = contact.frame.tr_mul(&self.between(i, mean)) + contact.bias;
        let velocity = velocity + impulse * contact.compliance;
        (contact, velocity, impulse, self.masses[i])
    }

    /// What the contacts do in the step of `dt` seconds where all fibres have the given mean
    /// velocities, without couples; drifts of more than half of `slip`, m/s, were to be undone.
    pub(crate) fn work(
        &self,
        system: &CoupledSystem,
        mean: &FiberVelocities,
        dt: f64,
        slip: f64,
    ) -> ContactWork {
        let mean = Velocities::new(system, mean);
        let of_one = |i: usize| {
            let point = &self.points[i];
            let (contact, velocity, impulse, _) = self.judged(i, &mean);
            let drive = contact.frame.tr_mul(&point.drive());
            if self.couple(i).is_some() {
                return ContactWork::default();
            }
            if contact.is_joint() {
                let kinematic = impulse.dot(&drive);
                let repair = impulse.dot(&contact.frame.tr_mul(&mean.between(point))) - kinematic;
                return ContactWork { repair, kinematic, ..Default::default() };
            }
            let before = self.before.get(i).map_or(Vector3::zeros(), |b| contact.frame.tr_mul(b));
            let given = (before - impulse) * contact.compliance;
            let back = contact.frame.tr_mul(&point.undone(dt, slip)).yz();
            let mut work = ContactWork {
                friction: impulse.yz().dot(&(velocity.yz() - back)),
                compliance: impulse.dot(&given),
                kinematic: impulse.dot(&drive),
                ..Default::default()
            };
            // What is pressed in without having given way.
            let gap = self.laws[i].gap + before.x * contact.compliance;
            let along = match impulse.x {
                pull if pull < 0.0 => &mut work.adhesion,
                _ if contact.bias.x < gap => &mut work.restitution,
                _ if gap < 0.0 => &mut work.repair,
                _ => &mut work.closing,
            };
            let opening = contact.frame.tr_mul(&mean.between(point)).x - drive.x;
            *along = impulse.x * (opening - given.x);
            work
        };
        self.summed(|i| if self.bears(i) { of_one(i) } else { ContactWork::default() })
    }

    /// Work of couples on fibres that have the given mean velocities, J.
    pub(crate) fn work_of_couples(&self, system: &CoupledSystem, mean: &FiberVelocities) -> f64 {
        let mean = Velocities::new(system, mean);
        let couples = self.points.len() - self.couples.len()..self.points.len();
        let of_one = |i: usize| {
            let way = self.points[i].frame().tr_mul(&self.between(i, &mean));
            self.impulses[i].dot(&way)
        };
        couples.map(of_one).sum()
    }

    /// The sum of something of all contacts that may bear, in an order that the number of threads
    /// does not change.
    fn summed<T: Default + AddAssign + Send>(&self, of_one: impl Fn(usize) -> T + Sync) -> T {
        let sum = |mut sum: T, one: T| {
            sum += one;
            sum
        };
        let part = |part: &[usize]| part.iter().map(|&i| of_one(i)).fold(T::default(), sum);
        let parts: Vec<T> = self.working.par_chunks(RESIDUAL_CHUNK).map(part).collect();
        parts.into_iter().fold(T::default(), sum)
    }

    /// Whether contacts with no kinematic object give, beyond what friction takes, a good part of
    /// the kinetic energy that there was before the step, where fibres have the given mean
    /// velocities. Those give whose normals turned within the step so far that along them they were
    /// deeper at its start than may be: `repair`, m/s, is how fast what may be is repaired. What
    /// errors of the slip up to `slip`, m/s, give does not count.
    pub(crate) fn drives(
        &self,
        system: &CoupledSystem,
        mean: &FiberVelocities,
        repair: f64,
        slip: f64,
    ) -> bool {
        let velocities = Velocities::new(system, mean);
        let given = |i: usize| {
            if self.points[i].drive() != Vector3::zeros() || i >= self.listed {
                return 0.0;
            }
            let (contact, velocity, impulse, _) = self.judged(i, &velocities);
            let friction = impulse.yz().dot(&velocity.yz()) - impulse.yz().norm() * slip;
            let gap = self.laws[i].gap + impulse.x * contact.compliance;
            impulse.x.max(0.0) * (-gap - repair).max(0.0) + friction
        };
        let gain: f64 = self.summed(given);
        gain > 0.0 && gain > MUCH * system.kinetic_energy()
    }

    /// Breaks the bonds of `strength`, N, that open against all that they bear, faster than
    /// `tolerance`, m/s, where all fibres have the given mean velocities.
    pub(crate) fn tear(
        &mut self,
        system: &CoupledSystem,
        mean: &FiberVelocities,
        strength: f64,
        tolerance: f64,
    ) -> Result<(), ContactError> {
        let mean = Velocities::new(system, mean);
        for i in 0..self.points.len() {
            if !self.points[i].bonded {
                continue;
            }
            let mut bond = Bond::new(strength)?;
            let (contact, velocity, impulse, _) = self.judged(i, &mean);
            bond.update(&contact, &velocity, &impulse, tolerance);
            self.points[i].bonded = bond.is_intact();
        }
        Ok(())
    }

    /// Notes how far contacts have slipped against the law in the step of `dt` seconds, from where
    /// they stuck, and which have not slid, where all fibres have the given mean velocities; drifts
    /// of more than half of `slip`, m/s, were to be undone. Returns the largest velocity of a
    /// contact that sticks, m/s.
    pub(crate) fn note_drifts(
        &mut self,
        system: &CoupledSystem,
        mean: &FiberVelocities,
        dt: f64,
        slip: f64,
    ) -> f64 {
        let mean = Velocities::new(system, mean);
        let of_one = |&i: &usize| {
            let (contact, velocity, impulse, masses) = self.judged(i, &mean);
            let ErrorMasses { own, .. } = masses;
            let wrong = Violation::forbidden_slip(&contact, &velocity, &impulse, own);
            let sticks = 2.0 * wrong.norm() > velocity.yz().norm();
            let of_drift = |way: Vector3<f64>| contact.frame.tr_mul(&way).yz();
            let undone = of_drift(self.points[i].undone(dt, slip));
            let speed = (velocity.yz() - undone).norm();
            if contact.compliance > 0.0 {
                // What gives way does not stick.
                return (Vector3::zeros(), 0.0, false);
            }
            // What slides has left where it stuck.
            let left = of_drift(self.points[i].drift) / dt - undone;
            let drift = if sticks { left + wrong } else { wrong };
            let drift = drift.cap_magnitude(2.0 * slip) * dt;
            let drift = contact.frame * Vector3::new(0.0, drift.x, drift.y);
            (drift, if sticks { speed } else { 0.0 }, sticks || speed <= slip)
        };
        // Joints come last.
        let contacts = &self.working[..self.working.partition_point(|&i| i < self.listed)];
        let found: Vec<_> = contacts.par_iter().map(of_one).collect();
        let mut largest = 0.0_f64;
        for (&i, (drift, creep, rests)) in self.working.iter().zip(found) {
            (self.points[i].drift, self.points[i].rests) = (drift, rests);
            largest = largest.max(creep);
        }
        largest
    }

    /// The contact points that may have closed where all fibres have the given mean velocities,
    /// with their gaps there.
    pub(crate) fn near(
        &self,
        system: &CoupledSystem,
        mean: &FiberVelocities,
        dt: f64,
    ) -> Vec<ContactPoint> {
        let mut near = self.near_where(system, &mean.nodes);
        near.retain(|&i| i < self.listed);
        let mean = Velocities::new(system, mean);
        let one = |&i: &usize| ContactPoint { gap: self.gap(i, &mean, dt), ..self.points[i] };
        near.par_iter().map(one).collect()
    }

    /// Sets the gaps along the normals to those where all fibres have the given mean velocities.
    pub(crate) fn set_gaps(&mut self, system: &CoupledSystem, mean: &FiberVelocities, dt: f64) {
        let mean = Velocities::new(system, mean);
        let gap = |i| self.gap(i, &mean, dt);
        let gaps: Vec<f64> = (0..self.points.len()).into_par_iter().map(gap).collect();
        self.points.iter_mut().zip(gaps).for_each(|(point, gap)| point.gap = gap);
    }

    /// The gap along the normal, m, where fibres have the given mean velocities.
    fn gap(&self, i: usize, mean: &Velocities, dt: f64) -> f64 {
        let law = &self.laws[i];
        // The bias may be another than that of the gap.
        dt * (law.opening(&self.points[i], mean) - law.bias.x + law.gap)
    }
}
