//! Any step, any mesh, any size: the box scheme goes on where it may lose accuracy.

mod common;

use common::GRAVITY;
use nalgebra::Vector3;
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::{BoxIntegrator, BoxOptions, Instant, Rod, RodIntegrator};

/// Mean and worst iterations of a step, and halvings in all.
#[derive(Debug)]
struct Cost {
    mean: f64,
    worst: usize,
    halvings: usize,
}

/// Steps a rod clamped at its root under `gravity` and demands that every step succeeds and every
/// state is finite.
fn run(fiber: Fiber, gravity: Vector3<f64>, rho: f64, dt: f64, steps: usize) -> Cost {
    let root = *fiber.root();
    let options = BoxOptions::with_damping(rho).expect("valid");
    let mut integrator = BoxIntegrator::new(Rod::new(fiber), options).expect("valid");
    let conditions = |_: f64| Instant::clamped(root, gravity);
    let (mut iterations, mut worst, mut halvings) = (0, 0, 0);
    for step in 0..steps {
        let report = integrator
            .step(dt, &conditions)
            .unwrap_or_else(|error| panic!("rho {rho}, dt {dt}, step {step}: {error}"));
        iterations += report.iterations;
        worst = worst.max(report.iterations);
        halvings += report.halvings;
    }
    let finite = |v: &Vector3<f64>| v.iter().all(|x| x.is_finite());
    let state = integrator.state();
    assert!(state.positions.iter().all(|p| finite(&p.coords)), "positions are finite");
    assert!(state.velocities.iter().all(finite), "velocities are finite");
    Cost { mean: iterations as f64 / steps as f64, worst, halvings }
}

/// The reference hair with a curl and a twist, under gravity with a fifth of it sideways.
fn curly() -> (Fiber, Vector3<f64>) {
    let curl = Vector3::new(0.0, 4.0, 12.0) / 0.3;
    let fiber = common::hair(100).with_natural_curvature(|_| curl).expect("finite");
    (fiber, GRAVITY + Vector3::new(0.0, 0.0, 0.2 * 9.81))
}

/// Fig. 3.19: steps from 10 us to 10 ms and meshes of 100 down to 6 segments.
#[test]
fn steps_and_meshes_of_all_sizes_run() {
    for segments in [100, 25, 6] {
        for dt in [1e-5, 1e-4, 1e-3, 1e-2] {
            let c = run(common::hair(segments), GRAVITY, 0.8, dt, 200);
            eprintln!("N {segments} dt {dt} {c:?}");
        }
    }
}

/// Hair of a radius from 1 um (gravity parameter 4e5) to 1 m (4e-7).
#[test]
fn radii_from_a_micrometre_to_a_metre_run() {
    for radius in [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0] {
        for dt in [1.0 / 30.0, 1e-3] {
            let fiber = Fiber::uniform(0.3, 50, Section::Circle { radius }, &Material::HAIR)
                .expect("valid")
                .with_root(common::planar_clamp(0.0));
            let c = run(fiber, GRAVITY, 0.8, dt, 200);
            eprintln!("r {radius} dt {dt} {c:?}");
        }
    }
}

/// Scaled rods with a gravity parameter up to 1e6, released horizontally.
#[test]
fn gravity_parameters_up_to_a_million_run() {
    for gamma in [1e-3, 1.0, 1e3, 1e6] {
        for dt in [0.2, 0.005] {
            let node = common::scaled(1.0 / gamma, 1.0 / gamma);
            let fiber = common::chain(50, |_| node).with_root(common::planar_clamp(0.0));
            let c = run(fiber, -Vector3::y(), 0.8, dt, 200);
            eprintln!("gamma {gamma} dt {dt} {c:?}");
        }
    }
}

#[test]
fn reference_hair_takes_few_iterations() {
    for (dt, steps) in [(1.0 / 30.0, 120), (0.01, 200), (0.001, 400)] {
        let planar = run(common::hair(100), GRAVITY, 0.8, dt, steps);
        let (fiber, gravity) = curly();
        let curly = run(fiber, gravity, 0.8, dt, steps);
        eprintln!("{dt} {planar:?} {curly:?}");
        assert!(planar.mean <= 5.0 && curly.mean <= 7.0, "dt {dt}: {planar:?}, {curly:?}");
    }
}

#[test]
#[ignore = "slow: 60 s, a minute of hair at three steps"]
fn a_minute_of_hair() {
    for (dt, steps) in [(1.0 / 30.0, 1800), (0.01, 6000), (0.001, 60_000)] {
        let planar = run(common::hair(100), GRAVITY, 0.8, dt, steps);
        let (fiber, gravity) = curly();
        let curly = run(fiber, gravity, 0.8, dt, steps);
        eprintln!("{dt} {planar:?} {curly:?}");
        assert!(planar.mean <= 5.0 && curly.mean <= 7.0, "dt {dt}: {planar:?}, {curly:?}");
    }
}
