//! Measured order of convergence in time and in space.

use crate::common::{orders, planar_clamp, scaled};
use nalgebra::{Point3, Translation3, Vector3};
use rapunzel_fiber::Fiber;
use rapunzel_rod_dynamic::{BoxIntegrator, BoxOptions, Coefficients, Instant, Rod, RodIntegrator};
use std::f64::consts::{PI, TAU};

/// A tapered, gently curled rod on a graded mesh.
fn fiber(segments: usize) -> Fiber {
    let place = |j: usize| {
        let x = j as f64 / segments as f64;
        x + 0.05 * (TAU * x).sin()
    };
    let node = |j: usize| {
        let s = place(j);
        let mut node = scaled(0.15 * (1.0 - 0.6 * s), 0.1 * (1.0 - 0.5 * s));
        node.linear_density = 1.3 - 0.5 * s;
        node.natural_curvature = Vector3::new(1.0 + s, 0.3, 0.2 - s);
        node
    };
    let lengths = (0..segments).map(|i| place(i + 1) - place(i)).collect();
    Fiber::new(planar_clamp(0.8), lengths, (0..=segments).map(node).collect()).expect("valid")
}

/// That rod while its clamp moves and gravity (partly sideways) comes on smoothly: the tip after
/// 1.2 time units.
fn tip(segments: usize, steps: usize, coefficients: Coefficients) -> Point3<f64> {
    let rod = Rod::damped(fiber(segments), 0.01);
    let options = BoxOptions { coefficients, ..BoxOptions::default() };
    let mut integrator = BoxIntegrator::new(rod, options).expect("valid");
    let duration = 1.2;
    let conditions = |t: f64| {
        let rise = 1.0 - (2.0 * t).cos();
        let shift = Translation3::new(0.05 * rise, 0.0, 0.02 * rise);
        let root = shift * planar_clamp(0.8 + 0.2 * rise);
        let factor = 0.5 * (1.0 - (PI * t / duration).cos());
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

#[test]
fn second_order_in_time_and_in_space() {
    for rho in [1.0, 0.8, 0.5, 0.0] {
        let k = Coefficients::second_order(rho).expect("in range");
        let time: Vec<_> = [40, 80, 160, 320].iter().map(|&steps| tip(16, steps, k)).collect();
        let space: Vec<_> = [10, 20, 40, 80].iter().map(|&n| tip(n, 40, k)).collect();
        let (time, space) = (order(&time), order(&space));
        assert!((time - 2.0).abs() < 0.1, "rho {rho}: order {time} in time");
        assert!((space - 2.0).abs() < 0.1, "rho {rho}: order {space} in space");
    }
}

#[test]
fn weights_of_the_thesis_are_of_first_order() {
    for k in [Coefficients::THESIS, Coefficients::THESIS_DAMPED] {
        let time: Vec<_> = [160, 320, 640, 1280].iter().map(|&steps| tip(10, steps, k)).collect();
        let time = order(&time);
        assert!((time - 1.0).abs() < 0.1, "{k:?}: order {time} in time");
    }
}
