//! Equilibria, reached as the steady state of a strongly damped motion.

use crate::common::{Elastica, HeavyRod, assert_second_order, chain, planar_clamp, scaled};
use nalgebra::Vector3;
use rapunzel_fiber::Fiber;
use rapunzel_oracles::cases;
use rapunzel_rod_dynamic::{
    BoxIntegrator, BoxOptions, Conditions, End, Instant, Load, Rod, RodIntegrator,
};
use std::f64::consts::PI;

const SEGMENTS: usize = 100;

/// Settles a rod in 60 long, strongly damped steps; conditions are asked at times from 0 to 1 and
/// then stay.
fn settle(fiber: Fiber, conditions: &(dyn Fn(f64) -> Instant + Sync)) -> BoxIntegrator {
    let rod = Rod::damped(fiber, 10.0);
    let options = BoxOptions::with_damping(0.0).expect("valid");
    let mut integrator = BoxIntegrator::new(rod, options).expect("valid");
    let ramped = |t: f64| conditions((t / 500.0).min(1.0));
    for step in 0..60 {
        let dt = if step < 20 { 25.0 } else { 1e3 };
        integrator.step(dt, &ramped as &dyn Conditions).expect("converges");
    }
    let state = integrator.state();
    let fastest = state.velocities.iter().map(|v| v.norm()).fold(0.0, f64::max);
    assert!(fastest < 1e-7, "still moves at {fastest}");
    integrator
}

/// A clamped rod of unit length and stiffness with this load at its tip, grown from nothing.
fn loaded(load: impl Fn(f64) -> (Load, Load) + Sync) -> Vec<Vector3<f64>> {
    let root = planar_clamp(0.0);
    let fiber = chain(SEGMENTS, |_| scaled(1.0, 1.0)).with_root(root);
    let conditions = |t: f64| {
        let (force, moment) = load(t);
        Instant { tip: End::Loaded { force, moment }, ..Instant::clamped(root, Vector3::zeros()) }
    };
    settle(fiber, &conditions).state().positions.iter().map(|p| p.coords).collect()
}

/// S2: the cantilever under a dead end load, elliptic integrals (Bisshopp and Drucker 1945).
#[test]
fn dead_tip_load() {
    for (a, shortening, drop) in [
        (1.0, 0.056_433_24, 0.301_720_77),
        (2.0, 0.160_641_72, 0.493_457_48),
        (5.0, 0.387_628_36, 0.713_791_52),
        (10.0, 0.554_995_60, 0.810_609_02),
    ] {
        let nodes = loaded(|t| (Load::World(Vector3::new(0.0, -a * t, 0.0)), Load::ZERO));
        let exact = Vector3::new(1.0 - shortening, -drop, 0.0);
        let error = (nodes[SEGMENTS] - exact).norm();
        assert!(error < 1e-4, "load {a}: tip off by {error:e}");
    }
}

/// S3: an end moment of 2 pi B / L bends the rod to a closed circle, exactly.
#[test]
fn end_moment_closes_a_circle() {
    let follower = loaded(|t| (Load::ZERO, Load::Follower(Vector3::new(2.0 * PI * t, 0.0, 0.0))));
    let world = loaded(|t| (Load::ZERO, Load::World(Vector3::new(0.0, 0.0, 2.0 * PI * t))));
    for nodes in [follower, world] {
        let gap = (nodes[SEGMENTS] - nodes[0]).norm();
        assert!(gap < 1e-8, "open by {gap:e}");
        // Half way round: a polygon of equal chords across a circle of circumference 1.
        let h = 1.0 / SEGMENTS as f64;
        let across = h / (PI * h).sin();
        assert!((nodes[SEGMENTS / 2].y - across).abs() < 1e-8, "{}", nodes[SEGMENTS / 2]);
    }
}

/// The tip under a follower load across the tip: seen from the tip the problem is one of initial
/// values, `psi'' = -a cos psi` with `psi = psi' = 0` there, integrated back to the root.
fn follower_tip(a: f64) -> Vector3<f64> {
    let steps = 4000;
    let h = -1.0 / f64::from(steps);
    let slope = |y: [f64; 4]| [y[1], -a * y[0].cos(), y[0].cos(), y[0].sin()];
    let add = |y: [f64; 4], k: [f64; 4], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
    let mut y = [0.0; 4];
    for _ in 0..steps {
        let k1 = slope(y);
        let k2 = slope(add(y, k1, 0.5 * h));
        let k3 = slope(add(y, k2, 0.5 * h));
        let k4 = slope(add(y, k3, h));
        let mean = std::array::from_fn(|i| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0);
        y = add(y, mean, h);
    }
    // The root's tangent is along x: turn by -psi(root); the root lies at -(x, y) from the tip.
    let (s, c) = (-y[0]).sin_cos();
    Vector3::new(-(c * y[2] - s * y[3]), -(s * y[2] + c * y[3]), 0.0)
}

/// S16: a load that follows the tip has another equilibrium than one that does not.
#[test]
fn follower_tip_load() {
    for a in [1.0, 4.0] {
        // d2 points down for a rod along x, so -d2 is counterclockwise across the rod.
        let nodes = loaded(|t| (Load::Follower(Vector3::new(0.0, -a * t, 0.0)), Load::ZERO));
        let dead = loaded(|t| (Load::World(Vector3::new(0.0, a * t, 0.0)), Load::ZERO));
        let error = (nodes[SEGMENTS] - follower_tip(a)).norm();
        assert!(error < 1e-4, "load {a}: tip {} off by {error:e}", nodes[SEGMENTS]);
        assert!((nodes[SEGMENTS] - dead[SEGMENTS]).norm() > 1e-2, "load {a}: the loads differ");
    }
}

/// From the nearest stable equilibrium to the tip of a settled planar rod. A push sideways while
/// gravity grows decides which, and moves upright rods off their unstable one.
fn elastica_error(case: &Elastica, segments: usize) -> Vector3<f64> {
    let root = planar_clamp(case.clamp_angle_deg.to_radians());
    let node = |s: f64| {
        let mut node = scaled(1.0 / case.g, 1.0 / case.g);
        node.natural_curvature.x = case.natural_curvature(s);
        node
    };
    let hung = settle(chain(segments, node).with_root(root), &|t| {
        Instant::clamped(root, Vector3::new(0.3 * (PI * t).sin(), -t, 0.0))
    });
    let tip = hung.state().positions[segments].coords;
    let stable = case.equilibria.iter().filter(|e| e.stable);
    stable
        .map(|e| tip - Vector3::new(e.tip[0], e.tip[1], 0.0))
        .min_by(|a, b| a.norm().total_cmp(&b.norm()))
        .expect("a stable equilibrium")
}

/// What the reference's 1e-10 and the steps' tolerance leave of an error.
const ACCURACY: f64 = 1e-6;

/// The heavy elastica: a rod settles at a stable equilibrium, with an error of second order.
#[test]
fn heavy_planar_rods_hang_as_the_reference() {
    let cases: Vec<Elastica> = cases("b_heavy_elastica_planar.json").expect("the oracle");
    for case in &cases {
        let [coarse, fine] = [SEGMENTS / 2, SEGMENTS].map(|count| elastica_error(case, count));
        assert_second_order(&case.name, &coarse, &fine, ACCURACY);
    }
}

/// Naturally curved rods in space, followed from no gravity to all of it.
#[test]
fn heavy_curled_rods_hang_as_the_reference() {
    let cases: Vec<HeavyRod> = cases("b_heavy_rod_3d.json").expect("the oracle");
    for case in &cases {
        let [coarse, fine] = [SEGMENTS / 2, SEGMENTS].map(|count| {
            let fiber = case.fiber(count);
            let root = *fiber.root();
            let gravity = |t: f64| Vector3::new(0.0, 0.0, -case.g * t);
            let hung = settle(fiber, &|t| Instant::clamped(root, gravity(t)));
            hung.state().positions[count].coords - Vector3::from(case.tip)
        });
        assert_second_order(&case.name, &coarse, &fine, ACCURACY);
    }
}
