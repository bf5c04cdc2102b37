//! Any step, any mesh, any size: the box scheme goes on where it may lose accuracy.

use crate::common::GRAVITY;
use nalgebra::Vector3;
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::{BoxIntegrator, BoxOptions, End, Instant, Rod, RodIntegrator, Steady};

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
    let fiber = crate::common::hair(100).with_natural_curvature(|_| curl).expect("finite");
    (fiber, GRAVITY + Vector3::new(0.0, 0.0, 0.2 * 9.81))
}

/// Fig. 3.19: steps from 10 us to 10 ms and meshes of 100 down to 6 segments.
#[test]
fn steps_and_meshes_of_all_sizes_run() {
    for segments in [100, 25, 6] {
        for dt in [1e-5, 1e-4, 1e-3, 1e-2] {
            let cost = run(crate::common::hair(segments), GRAVITY, 0.8, dt, 200);
            assert!(cost.mean <= 5.0 && cost.halvings == 0, "N {segments}, dt {dt}: {cost:?}");
        }
    }
}

/// Hair of a radius from 1 um (gravity parameter 4e5) to 1 m (4e-7), and scaled rods with a
/// gravity parameter up to 1e6, released horizontally.
fn sizes(segments: usize, steps: usize) {
    for radius in [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0] {
        for dt in [1.0 / 30.0, 1e-3] {
            let fiber = Fiber::uniform(0.3, segments, Section::Circle { radius }, &Material::HAIR)
                .expect("valid")
                .with_root(crate::common::planar_clamp(0.0));
            let cost = run(fiber, GRAVITY, 0.8, dt, steps);
            // A hair of 1 um is a whip: it has no bending stiffness to speak of.
            assert!(cost.halvings == 0 || radius <= 1e-5, "radius {radius}, dt {dt}: {cost:?}");
        }
    }
    for gamma in [1e-3, 1.0, 1e3, 1e6] {
        for dt in [0.2, 0.005] {
            let node = crate::common::scaled(1.0 / gamma, 1.0 / gamma);
            let fiber = crate::common::chain(segments, |_| node)
                .with_root(crate::common::planar_clamp(0.0));
            let cost = run(fiber, -Vector3::y(), 0.8, dt, steps);
            assert!(cost.halvings == 0 || gamma >= 1e3, "gamma {gamma}, dt {dt}: {cost:?}");
        }
    }
}

#[test]
fn rods_of_all_sizes_run() {
    sizes(20, 40);
}

#[test]
#[ignore = "slow: 30 s, 300 steps of 22 rods"]
fn rods_of_all_sizes_run_on() {
    sizes(50, 300);
}

/// A curly hair that is thrown: no end is held, and its rotary inertia is next to nothing.
#[test]
fn a_thrown_hair_flies() {
    let (fiber, gravity) = curly();
    let mut integrator = BoxIntegrator::new(Rod::new(fiber), BoxOptions::default()).expect("valid");
    let mut state = integrator.state();
    let rates = Vector3::new(1.0, 4.0, -3.0);
    for (v, r) in state.velocities.iter_mut().zip(&state.positions) {
        *v = rates.cross(&r.coords);
    }
    for (omega, frame) in state.angular_velocities.iter_mut().zip(&state.frames) {
        *omega = frame.inverse() * rates;
    }
    integrator.set_state(&state).expect("fits");
    let mean = |v: &[Vector3<f64>]| {
        v.windows(2).map(|v| 0.5 * (v[0] + v[1])).sum::<Vector3<f64>>() / (v.len() - 1) as f64
    };
    let start = mean(&state.velocities);
    let free =
        Instant { root: End::FREE, ..Instant::clamped(*integrator.rod().fiber.root(), gravity) };
    let mut halvings = 0;
    let steps = 60;
    for _ in 0..steps {
        halvings += integrator.step(1.0 / 60.0, &Steady(free)).expect("converges").halvings;
    }
    assert_eq!(halvings, 0, "none is needed");
    // Momentum balances hold in the material frames at the segments' middles, from which those of
    // the nodes, 12.6 / L of curvature away, differ by an angle whose square is lost.
    let lost = (12.65_f64 / 100.0).powi(2);
    let fall = mean(&integrator.state().velocities) - start;
    assert!((fall - gravity).norm() < lost * gravity.norm(), "{fall} for {gravity}");
}

#[test]
fn reference_hair_takes_few_iterations() {
    for (dt, steps) in [(1.0 / 30.0, 120), (0.01, 200), (0.001, 400)] {
        let planar = run(crate::common::hair(100), GRAVITY, 0.8, dt, steps);
        let (fiber, gravity) = curly();
        let curly = run(fiber, gravity, 0.8, dt, steps);
        assert!(planar.mean <= 5.0 && curly.mean <= 7.0, "dt {dt}: {planar:?}, {curly:?}");
        assert!(planar.worst <= 12 && planar.halvings == 0, "dt {dt}: {planar:?}");
        assert!(curly.worst <= 25 && curly.halvings <= 2, "dt {dt}: {curly:?}");
    }
}

#[test]
#[ignore = "slow: 150 s, a minute of hair at three steps"]
fn a_minute_of_hair() {
    for (dt, steps) in [(1.0 / 30.0, 1800), (0.01, 6000), (0.001, 60_000)] {
        let planar = run(crate::common::hair(100), GRAVITY, 0.8, dt, steps);
        let (fiber, gravity) = curly();
        let curly = run(fiber, gravity, 0.8, dt, steps);
        assert!(planar.mean <= 5.0 && curly.mean <= 7.0, "dt {dt}: {planar:?}, {curly:?}");
    }
}
