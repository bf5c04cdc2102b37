//! A scene in which no root and no object moves: what contacts carry there, and where fibres
//! settle.

use super::groups::{assembly, at_start, in_contact};
use super::start::FiberStart;
use crate::scene::{ContactSettings, Motion, RodMethod, Scene, Tip, Wind};
use crate::{Plan, SimError};
use nalgebra::{Point3, Vector3};
use rapunzel_coupling::{
    BundleConditions, CollisionObject, ContactJoints, FiberConditions, FibersInContact,
    Surroundings,
};
use std::sync::Arc;

/// Steps in a row in which all fibres must be slow: what is just let go is slow at first.
const SLOW_STEPS: usize = 20;
/// Viscosity of the air that slows down what settles, Pa s, at least: hair falls at half a metre
/// per second in it. Where fibres rest does not depend on it.
const AIR: f64 = 1.8e-5;

/// How far fibres are to settle.
pub(super) struct Settling {
    /// Speed at which a fibre has settled, in its length, 1/s.
    pub(super) speed: f64,
    /// Distance from where it started, m, beyond which a fibre does not settle there.
    pub(super) reach: f64,
    /// Most steps.
    pub(super) steps: usize,
    /// Largest Coulomb residual of a step, relative to all impulses.
    pub(super) residual: f64,
}

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
        for bundle in &mut scene.fibers {
            bundle.motion = Motion::Fixed;
            hold(&mut bundle.tip);
        }
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

    /// Lets the fibres settle under what acts on them at the start, by contacts that bear at first
    /// what they bore `before`. Returns them as they are in the end, and which of them have become
    /// slow.
    ///
    /// Dynamic relaxation (Day 1965) with kinetic damping: whenever the kinetic energy of a fibre
    /// has passed a maximum, its velocities are set to zero. It ends when all fibres are slow, or
    /// after a number of steps, and where contacts do not converge any more, with what there is.
    /// `at` is told the number of every step before it begins.
    pub(super) fn settle(
        &mut self,
        settings: &ContactSettings,
        settling: &Settling,
        before: Option<&FibersInContact>,
        at: &dyn Fn(usize),
    ) -> Result<(FibersInContact, Vec<bool>), SimError> {
        let dt = Plan::new(&self.scene).step_after(0);
        let mut around = at_start(&self.scene, &mut self.objects);
        let settings = ContactSettings { residual: settling.residual, ..settings.clone() };
        let mut fibers = bearing(&settings, &self.starts, &mut around)?;
        if let Some(before) = before {
            let numbers: Vec<_> = (0..).take(self.starts.len()).collect();
            fibers.expect_impulses_of(before, &numbers);
        }
        around.end = dt;
        let mut kinetic_before = vec![0.0; self.starts.len()];
        let first: Vec<_> = self.starts.iter().map(|start| start.state.clone()).collect();
        let (mut slow_steps, mut is_away) =
            (vec![0; self.starts.len()], vec![false; self.starts.len()]);
        for step in 0..settling.steps {
            at(step);
            if fibers.step(&mut around, dt).is_err() {
                break;
            }
            for (fiber, start) in self.starts.iter_mut().enumerate() {
                let mut state = fibers.fibers().state(fiber);
                let most = settling.speed * start.rod.fiber.length();
                let is_slow = state.velocities.iter().all(|velocity| velocity.norm() < most);
                slow_steps[fiber] = if is_slow { slow_steps[fiber] + 1 } else { 0 };
                let squares = state.velocities.iter().map(Vector3::norm_squared);
                let kinetic: f64 = squares.sum();
                let is_past = kinetic < kinetic_before[fiber];
                kinetic_before[fiber] = if is_past { 0.0 } else { kinetic };
                is_away[fiber] |= first[fiber].as_ref().is_some_and(|first| {
                    let ways = first.positions.iter().zip(&state.positions);
                    ways.into_iter().any(|(a, b)| (b - a).norm() > settling.reach)
                });
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
            let mut all = slow_steps.iter().zip(&is_away);
            if all.all(|(steps, is_away)| *steps >= SLOW_STEPS || *is_away) {
                break;
            }
        }
        // Ends stay where they are held, which states tell of only to the order of the segments.
        for (fiber, start) in self.starts.iter_mut().enumerate() {
            let FiberConditions { tip, taken, .. } = fibers.fibers().conditions(fiber);
            (start.tip, start.taken) = (Some(*tip), taken.clone());
        }
        let is_slow = slow_steps.iter().map(|steps| *steps >= SLOW_STEPS).collect();
        Ok((fibers, is_slow))
    }
}

/// Keeps a tip that is led at its pose at the start.
fn hold(tip: &mut Tip) {
    match tip {
        Tip::Free | Tip::Loaded { .. } | Tip::Held => {}
        Tip::Pulled { velocity, .. } => *velocity = [0.0; 3],
        Tip::Driven { velocity, twist, .. } => (*velocity, *twist) = ([0.0; 3], 0.0),
        Tip::Led { motion, .. } => *motion = Motion::Fixed,
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
