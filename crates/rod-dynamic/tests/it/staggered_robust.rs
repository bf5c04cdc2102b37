//! Any step, any mesh, any size: the staggered rod goes on where it may lose accuracy.

#![allow(clippy::cast_possible_truncation, reason = "step counts are small")]

use crate::common::GRAVITY;
use nalgebra::{Translation3, Vector3};
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::{
    End, Instant, Rod, RodIntegrator, RodStepReport, Staggered, StaggeredBatch, Steady, StepError,
};

/// What a run cost, and the largest energy above that of its start in parts of the weight times
/// the length.
#[derive(Debug)]
struct Cost {
    mean: f64,
    worst: usize,
    halvings: usize,
    gain: f64,
}

/// Steps a rod clamped at its root under `gravity`, from its natural or from the straight shape,
/// and demands that every step succeeds and every state is finite.
fn run(fiber: Fiber, gravity: Vector3<f64>, straight: bool, dt: f64, steps: usize) -> Cost {
    let root = *fiber.root();
    let scale = fiber.mass() * gravity.norm() * fiber.length();
    let mut integrator = Staggered::new(Rod::new(fiber)).expect("valid");
    if straight {
        let mut state = integrator.state();
        state.frames.fill(root.rotation.to_rotation_matrix());
        integrator.set_state(&state).expect("fits");
    }
    let conditions = |_: f64| Instant::clamped(root, gravity);
    let start = integrator.energy(&gravity).total();
    let mut cost = Cost { mean: 0.0, worst: 0, halvings: 0, gain: f64::MIN };
    for step in 0..steps {
        let report = integrator
            .step(dt, &conditions)
            .unwrap_or_else(|error| panic!("dt {dt}, step {step}: {error}"));
        cost.mean += report.iterations as f64 / steps as f64;
        cost.worst = cost.worst.max(report.iterations);
        cost.halvings += report.halvings;
        cost.gain = cost.gain.max((integrator.energy(&gravity).total() - start) / scale);
    }
    let finite = |v: &Vector3<f64>| v.iter().all(|x| x.is_finite());
    let state = integrator.state();
    assert!(state.positions.iter().all(|p| finite(&p.coords)), "positions are finite");
    assert!(state.velocities.iter().all(finite), "velocities are finite");
    cost
}

/// The reference hair with a curl and a twist, under gravity with a fifth of it sideways.
fn curly() -> (Fiber, Vector3<f64>) {
    let curl = Vector3::new(0.0, 4.0, 12.0) / 0.3;
    let fiber = crate::common::hair(100).with_natural_curvature(|_| curl).expect("finite");
    (fiber, GRAVITY + Vector3::new(0.0, 0.0, 0.2 * 9.81))
}

fn whips(duration: f64) {
    for dt in [1.0 / 30.0, 0.01, 0.001] {
        let steps = (duration / dt).round() as usize;
        let planar = run(crate::common::hair(100), GRAVITY, false, dt, steps);
        let (fiber, gravity) = curly();
        let natural = run(fiber.clone(), gravity, false, dt, steps);
        // A sixth of the weight times the length is let go at once, 12 rad of twist in it.
        let straight = run(fiber, gravity, true, dt, steps);
        for (name, cost) in [("planar", planar), ("curly", natural), ("straight", straight)] {
            assert!(cost.mean <= 5.5, "{name}, dt {dt}: {cost:?}");
            assert!(cost.worst <= 12, "{name}, dt {dt}: {cost:?}");
            assert!(
                cost.halvings as f64 <= (steps as f64 / 1e4).floor(),
                "{name}, dt {dt}: {cost:?}"
            );
            assert!(cost.gain <= 0.0, "{name}, dt {dt}: {cost:?}");
        }
    }
}

/// Mean iterations, worst step and halvings of a hair whose free end whips, and never more energy
/// than at its start. No step of two seconds is halved.
#[test]
fn a_whip_takes_few_iterations() {
    whips(2.0);
}

#[test]
#[ignore = "slow: 120 s, a minute of three hairs at three steps"]
fn a_minute_of_whips_takes_few_iterations() {
    whips(60.0);
}

/// Hair of a radius from 1 um (gravity parameter 4e5) to 1 m (4e-7), and scaled rods with a
/// gravity parameter up to 1e6, released horizontally.
fn sizes(segments: usize, steps: usize) {
    for radius in [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0] {
        for dt in [1.0 / 30.0, 1e-3] {
            let fiber = Fiber::uniform(0.3, segments, Section::Circle { radius }, &Material::HAIR)
                .expect("valid")
                .with_root(crate::common::planar_clamp(0.0));
            let cost = run(fiber, GRAVITY, false, dt, steps);
            // A hair of 1 um is a whip: it has no bending stiffness to speak of.
            assert!(cost.halvings == 0 || radius <= 1e-6, "radius {radius}, dt {dt}: {cost:?}");
        }
    }
    for gamma in [1e-3, 1.0, 1e3, 1e6] {
        for dt in [0.2, 0.005] {
            let node = crate::common::scaled(1.0 / gamma, 1.0 / gamma);
            let fiber = crate::common::chain(segments, |_| node)
                .with_root(crate::common::planar_clamp(0.0));
            let cost = run(fiber, -Vector3::y(), false, dt, steps);
            assert!(cost.halvings == 0 || gamma >= 1e6, "gamma {gamma}, dt {dt}: {cost:?}");
        }
    }
}

#[test]
fn rods_of_all_sizes_run() {
    for (segments, steps) in [(6, 100), (100, 100), (1000, 10), (10_000, 2)] {
        sizes(segments, steps);
    }
}

/// Held straight at both ends a rod cannot move, and has any tension: that is told before a step.
#[test]
fn a_taut_rod_is_refused() {
    let rod = Rod::new(crate::common::hair(20));
    for slack in [0.0, 1e-10, -1e-10] {
        for batch in [
            StaggeredBatch::new(vec![rod.clone()], 0.3),
            StaggeredBatch::backward_euler(vec![rod.clone()]),
        ] {
            let mut batch = batch.expect("a valid rod");
            let root = *rod.fiber.root();
            let tip = root * Translation3::new(0.0, 0.0, rod.fiber.length() * (1.0 - slack));
            let taut = Instant { tip: End::Held(tip), ..Instant::clamped(root, GRAVITY) };
            let mut reports = [RodStepReport::default()];
            let error = batch.step(1e-3, &[&Steady(taut)], &mut reports).expect_err("it is taut");
            assert!(matches!(error, StepError::Conditions { what: "tip", .. }), "{error}");
        }
    }
}
