//! Large planar swings of the staggered rod against the independent reference.

#![allow(clippy::doc_markdown, reason = "names of oracle cases")]

use crate::common::Swing;
use nalgebra::Vector3;
use rapunzel_oracles::cases;
use rapunzel_rod_dynamic::{Instant, Rod, RodIntegrator, Staggered};

/// The largest distance of the tip from the reference at any of its times.
fn error(case: &Swing, segments: usize, dt: f64, rho: f64) -> f64 {
    let fiber = case.fiber(segments);
    let root = *fiber.root();
    let rod = Rod::damped(fiber, case.damp);
    let mut integrator = Staggered::with_rho_inf(rod, rho).expect("valid");
    let conditions = |t: f64| Instant::clamped(root, case.gravity(t));
    let mut worst = 0.0_f64;
    for (t, tip) in case.t.iter().zip(&case.tip) {
        while integrator.time() < t - 0.5 * dt {
            integrator.step(dt, &conditions).expect("converges");
        }
        let position = integrator.state().positions[segments].coords;
        worst = worst.max((position - Vector3::new(tip[0], tip[1], 0.0)).norm());
    }
    worst
}

/// Gravity that comes on smoothly: the error is of second order, and below the 1e-2 that the
/// reference expects of 100 segments after a sudden release.
#[test]
fn ramped_swings_converge_with_second_order() {
    let cases: Vec<Swing> = cases("d_planar_swing.json").expect("the oracle");
    let ramped = cases.iter().filter(|c| c.ramp_time > 0.0);
    for case in ramped {
        for rho in [0.0, 0.3, 0.5] {
            let coarse = error(case, 50, 0.025, rho);
            let fine = error(case, 100, 0.0125, rho);
            let order = (coarse / fine).log2();
            assert!((order - 2.0).abs() < 0.2, "{} rho {rho}: order {order}", case.name);
            assert!(fine < 1e-2 + case.accuracy, "{} rho {rho}: {fine:e}", case.name);
        }
    }
}

/// A sudden release sets all bending modes going: 1e-2 is what 100 segments can hold over three
/// time units, and the error falls with the mesh.
#[test]
fn released_swings_follow_the_reference() {
    let cases: Vec<Swing> = cases("d_planar_swing.json").expect("the oracle");
    let released = cases.iter().filter(|c| c.ramp_time == 0.0);
    for case in released {
        for rho in [0.3, 0.5] {
            let coarse = error(case, 50, 0.025, rho);
            let fine = error(case, 100, 0.0125, rho);
            assert!(fine < 1e-2 + case.accuracy, "{} rho {rho}: {fine:e}", case.name);
            assert!(fine < 0.5 * coarse, "{} rho {rho}: {fine:e} after {coarse:e}", case.name);
        }
    }
}
