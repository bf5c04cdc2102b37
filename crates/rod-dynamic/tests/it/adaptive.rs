//! Adaptive steps keep the error that was asked for.

use crate::common::{chain, planar_clamp, scaled};
use nalgebra::{Point3, Vector3};
use rapunzel_rod_dynamic::adaptive::{self, AdaptiveReport};
use rapunzel_rod_dynamic::{BoxIntegrator, BoxOptions, Instant, Rod, RodIntegrator, StepError};

/// A rod under gravity that comes on smoothly; all nodes after two time units.
fn swing(tolerance: f64) -> (Vec<Point3<f64>>, AdaptiveReport) {
    let root = planar_clamp(0.4);
    let rod = Rod::new(chain(20, |_| scaled(0.1, 0.1)).with_root(root));
    let mut integrator = BoxIntegrator::new(rod, BoxOptions::default()).expect("valid");
    let conditions = |t: f64| {
        let factor = 0.5 * (1.0 - (std::f64::consts::PI * t.min(1.0)).cos());
        Instant::clamped(root, -factor * Vector3::y())
    };
    let report =
        adaptive::advance(&mut integrator, 2.0, tolerance, &conditions).expect("converges");
    assert!((integrator.time() - 2.0).abs() < 1e-11, "it ends where asked");
    (integrator.state().positions, report)
}

#[test]
fn errors_stay_below_the_tolerance_and_cost_its_root() {
    let (exact, fine) = swing(1e-6);
    let mut steps = Vec::new();
    for tolerance in [3e-3, 3e-4, 3e-5] {
        let (nodes, report) = swing(tolerance);
        let error = nodes.iter().zip(&exact).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        // The steps' own errors add up to the tolerance; those of velocities grow into as much.
        assert!(error < 2.0 * tolerance, "error {error:e} for {tolerance:e}: {report:?}");
        assert!(report.error <= tolerance && report.missed == 0, "{report:?}");
        steps.push(report.steps as f64);
    }
    // Second order: a hundredth of the error takes ten times the steps.
    let ratio = steps[2] / steps[0];
    assert!((5.0..20.0).contains(&ratio), "steps {steps:?}");
    assert!(fine.steps as f64 > steps[2], "{fine:?}");
}

#[test]
fn nonsense_is_refused_and_changes_nothing() {
    let root = planar_clamp(0.0);
    let rod = Rod::new(chain(5, |_| scaled(0.1, 0.1)).with_root(root));
    let mut integrator = BoxIntegrator::new(rod, BoxOptions::default()).expect("valid");
    let before = integrator.state();
    let good = |_: f64| Instant::clamped(root, -Vector3::y());
    let bad = |t: f64| {
        Instant::clamped(root, if t < 0.5 { -Vector3::y() } else { Vector3::repeat(f64::NAN) })
    };
    assert_eq!(
        adaptive::advance(&mut integrator, -1.0, 1e-3, &good),
        Err(StepError::TimeStep(-1.0))
    );
    assert!(adaptive::advance(&mut integrator, 1.0, 0.0, &good).is_err(), "no tolerance");
    let error = adaptive::advance(&mut integrator, 1.0, 1e-3, &bad).expect_err("NaN later on");
    assert!(matches!(error, StepError::Conditions { .. }), "{error}");
    assert_eq!(before, integrator.state(), "untouched");
}
