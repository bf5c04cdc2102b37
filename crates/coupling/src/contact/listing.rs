//! What may touch where a step leads, and the problem that is made of it.

use super::detection::Overlaps;
use super::laws::ContactLaws;
use super::node_arrays::FiberVelocities;
use super::node_motion::NodeMotion;
use super::problem::{ContactLists, ContactProblem};
use super::stepper::ContactStepper;
use super::substep::Substep;
use super::substep_failure::SubstepFailure;
use super::system::CoupledSystem;
use super::velocities::Velocities;
use super::warm_start::{ExpectedImpulses, cache_impulses, cached_impulses, match_cached};
use crate::body_ref::BodyRef;
use crate::contact_point::ContactPoint;
use crate::held_places::{HeldPlace, HeldPlaces};
use crate::merging::merge;
use crate::phase_times::PhaseTimer;
use crate::{FiberGroup, TimeInterval};
use nalgebra::Vector3;
use rapunzel_collision::CollisionError;
use rapunzel_rod_dynamic::Impulses;

/// How much deeper, in the depth that is allowed, a fibre may be beside where it rests on an
/// object: less than what is worth a contact of its own.
const HELD: f64 = 0.25;

impl ContactStepper {
    /// The problem of contact points that were listed where the step has been solved to. From now
    /// on no impulses act but theirs.
    pub(super) fn case(
        &mut self,
        system: &mut CoupledSystem,
        part: &mut Substep,
        expected: &ExpectedImpulses,
        points: Vec<ContactPoint>,
    ) -> Result<ContactProblem, SubstepFailure> {
        let mut laps = PhaseTimer::start(self.stopwatch);
        let gravity = system.environment.gravity_at(part.time + 0.5 * part.dt).norm();
        let laws =
            ContactLaws::new(&self.settings, self.film.as_ref(), system.objects, gravity, part.dt);
        let gives = self.settings.compliance > 0.0;
        let before = if gives { cached_impulses(expected, &points) } else { Vec::new() };
        let step = TimeInterval { start: part.time, length: part.dt };
        let all = &self.detector.joints;
        let joints = all.points(system, step, &self.memory.joints);
        let moments = &self.memory.joints[joints.len()..];
        let couples = all.junctions.points(system.fibers, part.dt, moments);
        let lists = ContactLists { points, joints, couples };
        let room = std::mem::take(&mut self.room);
        let (mut case, mean) =
            ContactProblem::new(system, lists, part.dt, &laws, before, self.segment_mass, room)?;
        self.bend(system, &mut case, &mean, part.dt);
        part.set_mean(mean);
        laps.lap(&mut self.times.laws);
        system.push(case.pushes(), part.time, part.dt)?;
        let press = |group: &mut FiberGroup<_>, own: Impulses| group.press(own);
        let pressed = system.fibers.with_impulses(&part.all(), case.pushes(), press)?;
        part.note_pressed(&pressed);
        laps.lap(&mut self.times.rods);
        Ok(case)
    }

    /// Takes the law of what bends at joints where fibres have the given mean velocities.
    pub(super) fn bend(
        &self,
        system: &CoupledSystem,
        case: &mut ContactProblem,
        mean: &FiberVelocities,
        dt: f64,
    ) {
        let junctions = &self.detector.joints.junctions;
        if !junctions.is_empty() {
            case.bend(&Velocities::new(system, mean), &junctions.moments(system.fibers, dt));
        }
    }

    /// Lists anew the contact points of fibres that have moved, of all groups but `others`, between
    /// those of a list that are of nothing else.
    pub(super) fn list_moved(
        &mut self,
        system: &CoupledSystem,
        part: &mut Substep,
        expected: &ExpectedImpulses,
        mut points: Vec<ContactPoint>,
        others: &[bool],
    ) -> Result<Vec<ContactPoint>, CollisionError> {
        let mut moved = vec![false; system.fibers.assembly().fibers().len()];
        for (group, _) in system.fibers.groups.iter().zip(others).filter(|(_, other)| !**other) {
            group.fibers.iter().for_each(|&fiber| moved[fiber] = true);
        }
        let has_moved = |side: &BodyRef| matches!(side, BodyRef::Fiber(i) if moved[*i as usize]);
        points.retain(|point| !point.sides.iter().any(has_moved));
        let new = self.list(system, part, expected, Some(&moved))?;
        merge(&mut points, new, |point, new| point.rank() > new.rank());
        Ok(points)
    }

    /// Lists the contact points where the step leads, of all or of the fibres that are `sought`,
    /// with the impulses expected of them.
    pub(super) fn list(
        &mut self,
        system: &CoupledSystem,
        part: &mut Substep,
        expected: &ExpectedImpulses,
        sought: Option<&[bool]>,
    ) -> Result<Vec<ContactPoint>, CollisionError> {
        let mut laps = PhaseTimer::start(self.stopwatch);
        let mut points = std::mem::take(&mut self.points);
        let motion = NodeMotion { sought, ..part.motion(system, &self.shapes) };
        let held: Vec<HeldPlace> = expected.held_places().collect();
        let held = HeldPlaces { places: &held, slack: HELD * self.depth() };
        self.detector.detect(&motion, system.objects, &held, &mut points)?;
        match_cached(expected, &mut points);
        motion.sections.settle(motion.layout, motion.step.length, expected, &mut points);
        laps.lap(&mut self.times.detection);
        Ok(points)
    }

    /// Lists what overlaps where the substep has been solved to, with such contacts; how deep at
    /// most is told where these do not give way.
    pub(super) fn look_at_end(
        &mut self,
        system: &CoupledSystem,
        part: &mut Substep,
        bearing: &[ContactPoint],
    ) -> Result<Overlaps, CollisionError> {
        let mut laps = PhaseTimer::start(self.stopwatch);
        let motion = part.motion(system, &self.shapes);
        let shallow = self.shallow();
        let mut found = self.detector.overlaps(&motion, system.objects, shallow)?;
        if self.settings.compliance > 0.0 {
            // What is not listed is no deeper.
            let mut known = Vec::new();
            cache_impulses(bearing, &mut known);
            let impulses =
                cached_impulses(&ExpectedImpulses { known: &known, scale: 1.0 }, &found.points);
            let gives = self.settings.compliance / part.dt;
            let depth = |(point, impulse): (&ContactPoint, Vector3<f64>)| {
                -point.gap - gives * impulse.dot(&point.normal)
            };
            let depths = found.points.iter().zip(impulses).map(depth);
            found.deepest = depths.fold(found.deepest.min(shallow), f64::max);
        }
        laps.lap(&mut self.times.detection);
        Ok(found)
    }
}
