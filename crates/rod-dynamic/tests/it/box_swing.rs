//! Large planar swings against the independent reference.

use crate::common::Swing;
use nalgebra::Vector3;
use rapunzel_oracles::cases;
use rapunzel_rod_dynamic::{BoxIntegrator, BoxOptions, Instant, Rod, RodIntegrator};

/// From the reference to the tip at each of its times.
fn errors(case: &Swing, segments: usize, dt: f64, rho: f64) -> Vec<Vector3<f64>> {
    let fiber = case.fiber(segments);
    let root = *fiber.root();
    let rod = Rod::damped(fiber, case.damp);
    let options = BoxOptions::with_damping(rho).expect("valid");
    let mut integrator = BoxIntegrator::new(rod, options).expect("valid");
    let conditions = |t: f64| Instant::clamped(root, case.gravity(t));
    let mut errors = Vec::with_capacity(case.t.len());
    for (t, tip) in case.t.iter().zip(&case.tip) {
        while integrator.time() < t - 0.5 * dt {
            integrator.step(dt, &conditions).expect("converges");
        }
        let position = integrator.state().positions[segments].coords;
        errors.push(position - Vector3::new(tip[0], tip[1], 0.0));
    }
    errors
}

fn largest(errors: &[Vector3<f64>]) -> f64 {
    errors.iter().map(Vector3::norm).fold(0.0, f64::max)
}

/// Gravity that comes on smoothly: the error is of second order at every time.
#[test]
fn ramped_swings_converge_with_second_order() {
    let cases: Vec<Swing> = cases("d_planar_swing.json").expect("the oracle");
    let ramped = cases.iter().filter(|c| c.ramp_time > 0.0);
    for case in ramped {
        for rho in [1.0, 0.8, 0.5] {
            // Fine enough for the term of third order, which damping has, to be small beside it.
            let coarse = errors(case, 100, 0.0125, rho);
            let fine = errors(case, 200, 0.00625, rho);
            let pairs = coarse.iter().zip(&fine);
            let left: Vec<_> = pairs.map(|(coarse, fine)| (fine * 4.0 - coarse) / 3.0).collect();
            let [left, fine] = [largest(&left), largest(&fine)];
            let name = &case.name;
            assert!(left < 0.25 * fine + case.accuracy, "{name} rho {rho}: {left:e} of {fine:e}");
        }
    }
}

/// A sudden release sets all bending modes going, also those that no mesh resolves: the error falls
/// with the mesh, by less than with its square.
#[test]
fn released_swings_follow_the_reference() {
    let cases: Vec<Swing> = cases("d_planar_swing.json").expect("the oracle");
    let released = cases.iter().filter(|c| c.ramp_time == 0.0);
    for case in released {
        let coarse = largest(&errors(case, 50, 0.025, 0.8));
        let fine = largest(&errors(case, 100, 0.0125, 0.8));
        assert!(fine < 0.5 * coarse + case.accuracy, "{}: {fine:e} after {coarse:e}", case.name);
    }
}
