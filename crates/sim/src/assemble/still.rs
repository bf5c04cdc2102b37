//! A scene in which no root and no object moves: what contacts carry there, and where fibres
//! settle.

use super::groups::{assembly, at_start, in_contact};
use super::start::FiberStart;
use crate::scene::{ContactSettings, Motion, RodMethod, Scene, Wind};
use crate::{Plan, SimError};
use nalgebra::{Point3, Vector3};
use rapunzel_coupling::{
    BundleConditions, CollisionObject, ContactJoints, FibersInContact, Surroundings,
};
use std::sync::Arc;

/// Speed at which a fibre has settled, in its length, 1/s: in 0.1 s it moves by half a thousandth
/// of it.
const SETTLED: f64 = 5e-3;
/// Steps in a row in which all fibres must be that slow: what is just let go is slow at first.
const SLOW_STEPS: usize = 20;
/// Most steps of settling at once.
pub(super) const MOST_STEPS: usize = 75;
/// Largest Coulomb residual of a step of settling, relative to all impulses: how fibres come to
/// where they rest does not count.
const RESIDUAL: f64 = 1e-2;
/// Viscosity of the air that slows down what settles, Pa s, at least: hair falls at half a metre
/// per second in it. Where fibres rest does not depend on it.
const AIR: f64 = 1.8e-5;

/// Fibres among objects, all held.
pub(super) struct Still {
    scene: Scene,
    objects: Vec<CollisionObject>,
    pub(super) starts: Vec<FiberStart>,
}

impl Still {
    /// The fibres and objects of a scene as they are at its start, without motion.
    pub(super) fn new(
        scene: &Scene,
        starts: &[FiberStart],
        objects: &[CollisionObject],
    ) -> Result<Self, SimError> {
        let mut scene = scene.clone();
        scene.fibers.iter_mut().for_each(|bundle| bundle.motion = Motion::Fixed);
        scene.environment.viscosity = scene.environment.viscosity.max(AIR);
        scene.environment.wind = Wind::default();
        let conditions = scene.fibers.iter().enumerate().map(|(index, bundle)| {
            let own = starts.iter().filter(|start| start.bundle == index);
            let sizes = own.map(|start| {
                let fiber = &start.rod.fiber;
                let middle = fiber.nodes()[fiber.segments() / 2];
                (fiber.length(), middle.section.equivalent_radius())
            });
            let (length, radius) = sizes.fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
            let conditions = BundleConditions::new(&scene, bundle, length, radius);
            conditions.map(Arc::new).map_err(|source| SimError::Rod { bundle: index, source })
        });
        let conditions = conditions.collect::<Result<Vec<_>, _>>()?;
        let held = |start: &FiberStart| FiberStart {
            conditions: Arc::clone(&conditions[start.bundle]),
            velocity: Vector3::zeros(),
            spin: (Vector3::zeros(), Point3::origin()),
            velocities: Vec::new(),
            ..start.clone()
        };
        let starts = starts.iter().map(held).collect();
        let objects = objects.iter().map(|object| object.held(0.0)).collect();
        Ok(Self { scene, objects, starts })
    }

    /// Forces of contacts on all nodes, N, world, a mean over the first step.
    pub(super) fn contact_forces(
        &mut self,
        settings: &ContactSettings,
    ) -> Result<Vec<Vector3<f64>>, SimError> {
        let dt = Plan::new(&self.scene).step_after(0);
        let mut around = at_start(&self.scene, &mut self.objects);
        let mut fibers = bearing(settings, &self.starts, &mut around)?;
        around.end = dt;
        fibers.step(&mut around, dt)?;
        Ok(fibers.contact_forces())
    }

    /// Lets the fibres settle. Returns the forces of contacts on all nodes in the end, N, world.
    ///
    /// Dynamic relaxation (Day 1965) with kinetic damping: whenever the kinetic energy of a fibre
    /// has passed a maximum, its velocities are set to zero. It ends when all fibres are slow, or
    /// after a number of steps, and where contacts do not converge any more, with what there is.
    /// `at` is told the number of every step before it begins.
    pub(super) fn settle(
        &mut self,
        settings: &ContactSettings,
        at: &dyn Fn(usize),
    ) -> Result<Vec<Vector3<f64>>, SimError> {
        let dt = Plan::new(&self.scene).step_after(0);
        let mut around = at_start(&self.scene, &mut self.objects);
        let settings = ContactSettings { residual: RESIDUAL, ..settings.clone() };
        let mut fibers = bearing(&settings, &self.starts, &mut around)?;
        let (mut before, mut slow_steps) = (vec![0.0; self.starts.len()], 0);
        for step in 0..MOST_STEPS {
            at(step);
            (around.start, around.end) = (step as f64 * dt, (step + 1) as f64 * dt);
            if fibers.step(&mut around, dt).is_err() {
                break;
            }
            let mut states = Vec::with_capacity(self.starts.len());
            states.extend((0..self.starts.len()).map(|fiber| fibers.fibers().state(fiber)));
            let is_slow = states.iter().zip(&self.starts).all(|(state, start)| {
                let most = SETTLED * start.rod.fiber.length();
                state.velocities.iter().all(|velocity| velocity.norm() < most)
            });
            slow_steps = if is_slow { slow_steps + 1 } else { 0 };
            let all = self.starts.iter_mut().zip(states).zip(&mut before).enumerate();
            for (fiber, ((start, mut state), before)) in all {
                let squares = state.velocities.iter().map(Vector3::norm_squared);
                let kinetic: f64 = squares.sum();
                let is_past = kinetic < *before;
                *before = if is_past { 0.0 } else { kinetic };
                state.velocities.fill(Vector3::zeros());
                state.angular_velocities.fill(Vector3::zeros());
                if is_past {
                    let set = fibers.fibers_mut().set_state(fiber, &state);
                    set.map_err(|source| SimError::State { fiber, source })?;
                }
                state.time = 0.0;
                if start.state.is_some() {
                    start.state = Some(state);
                }
            }
            if slow_steps == SLOW_STEPS {
                break;
            }
        }
        Ok(fibers.contact_forces())
    }
}

/// Fibres in contact by backward Euler: what rests comes to rest soonest.
fn bearing(
    settings: &ContactSettings,
    starts: &[FiberStart],
    around: &mut Surroundings<'_>,
) -> Result<FibersInContact, SimError> {
    let how = (RodMethod::BackwardEuler, false);
    in_contact(settings, how, starts, assembly(starts), ContactJoints::default(), around)
}
