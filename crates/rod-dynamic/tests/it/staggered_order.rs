//! Measured order of convergence of the staggered rod in time and in space.

use crate::common::{orders, planar_clamp, scaled};
use nalgebra::{Point3, Translation3, Vector3};
use rapunzel_fiber::Fiber;
use rapunzel_rod_dynamic::{Instant, Rod, RodIntegrator, Staggered};
use std::f64::consts::{PI, TAU};

/// A tapered, gently curled rod on a graded mesh; its natural curvature varies by `varies`.
fn fiber(segments: usize, varies: f64) -> Fiber {
    let place = |j: usize| {
        let x = j as f64 / segments as f64;
        x + 0.05 * (TAU * x).sin()
    };
    let node = |j: usize| {
        let s = place(j);
        let mut node = scaled(0.15 * (1.0 - 0.6 * s), 0.1 * (1.0 - 0.5 * s));
        node.linear_density = 1.3 - 0.5 * s;
        node.natural_curvature = Vector3::new(1.0 + varies * s, 0.3, 0.2 - varies * s);
        node
    };
    let lengths = (0..segments).map(|i| place(i + 1) - place(i)).collect();
    Fiber::new(planar_clamp(0.8), lengths, (0..=segments).map(node).collect()).expect("valid")
}

/// A rod's motion over 1.2 time units.
#[derive(Clone, Copy)]
struct Motion {
    varies: f64,
    damping_time: f64,
    /// Released at once; else its clamp moves while gravity (partly sideways) comes on smoothly.
    sudden: bool,
}

/// The tip at the end of a motion.
fn tip(segments: usize, steps: usize, rho: f64, motion: Motion) -> Point3<f64> {
    let rod = Rod::damped(fiber(segments, motion.varies), motion.damping_time);
    let mut integrator = Staggered::with_rho_inf(rod, rho).expect("valid");
    let duration = 1.2;
    let conditions = |t: f64| {
        let rise = if motion.sudden { 0.0 } else { 1.0 - (2.0 * t).cos() };
        let shift = Translation3::new(0.05 * rise, 0.0, 0.02 * rise);
        let root = shift * planar_clamp(0.8 + 0.2 * rise);
        let factor = if motion.sudden { 1.0 } else { 0.5 * (1.0 - (PI * t / duration).cos()) };
        Instant::clamped(root, factor * Vector3::new(0.0, -1.0, 0.3))
    };
    for _ in 0..steps {
        let report = integrator.step(duration / steps as f64, &conditions).expect("converges");
        assert_eq!(report.halvings, 0, "the steps are those asked for");
    }
    *integrator.state().positions.last().expect("a tip")
}

/// Order from the differences of neighbours in a list of results, each with half the step.
fn order(tips: &[Point3<f64>]) -> f64 {
    let differences: Vec<f64> = tips.windows(2).map(|t| (t[1] - t[0]).norm()).collect();
    let steps: Vec<f64> =
        std::iter::successors(Some(1.0), |h| Some(0.5 * h)).take(differences.len()).collect();
    *orders(&steps, &differences).last().expect("three results")
}

/// Demands order 2 in time, of `segments` segments, and in space, over `steps` steps.
fn check(motion: Motion, segments: usize, steps: usize) {
    for rho in [0.0, 0.3, 0.5, 0.8, 1.0] {
        let time = [1, 2, 4, 8].map(|parts| tip(segments, 80 * parts, rho, motion));
        let time = order(&time);
        assert!((time - 2.0).abs() < 0.1, "rho {rho}: order {time} in time");
        let space = [10, 20, 40, 80].map(|n| tip(n, steps, rho, motion));
        let space = order(&space);
        assert!((space - 2.0).abs() < 0.1, "rho {rho}: order {space} in space");
    }
}

#[test]
fn second_order_in_gentle_motion() {
    check(Motion { varies: 0.0, damping_time: 0.01, sudden: false }, 16, 80);
    check(Motion { varies: 1.0, damping_time: 0.01, sudden: false }, 16, 80);
}

/// A sudden release wakes all modes; internal damping stops those that are not resolved.
#[test]
fn second_order_after_a_sudden_release() {
    check(Motion { varies: 0.0, damping_time: 0.1, sudden: true }, 16, 160);
}

/// Without damping, few segments have few modes: the steps resolve them all. (Less numerical
/// damping than this needs halved steps when the end whips.)
#[test]
fn second_order_in_time_after_an_undamped_release() {
    for rho in [0.0, 0.3, 0.5] {
        let motion = Motion { varies: 1.0, damping_time: 0.0, sudden: true };
        let order = order(&[320, 640, 1280, 2560].map(|steps| tip(4, steps, rho, motion)));
        assert!((order - 2.0).abs() < 0.1, "rho {rho}: order {order}");
    }
}

/// The joint at the clamp must start from the rotation it has: a false start is a jump, which
/// internal damping answers with an impulse, and the order falls to one.
#[test]
fn damping_keeps_second_order_where_natural_curvature_varies() {
    check(Motion { varies: 1.0, damping_time: 1.0, sudden: false }, 4, 160);
}
