//! Large planar swings against the independent reference.

mod common;

use common::{Oracle, Swing};
use nalgebra::Vector3;
use rapunzel_rod_dynamic::{BoxIntegrator, BoxOptions, Instant, Rod, RodIntegrator};

/// The largest distance of the tip from the reference, and the mean number of iterations.
fn error(case: &Swing, segments: usize, dt: f64, rho: f64) -> (f64, f64) {
    let fiber = case.fiber(segments);
    let root = *fiber.root();
    let rod = Rod { fiber, damping_time: case.damp };
    let options = BoxOptions::with_damping(rho).expect("valid");
    let mut integrator = BoxIntegrator::new(rod, options).expect("valid");
    let conditions = |t: f64| Instant::clamped(root, case.gravity(t));
    let (mut worst, mut steps, mut iterations) = (0.0_f64, 0, 0);
    for (t, tip) in case.t.iter().zip(&case.tip) {
        while integrator.time() < t - 0.5 * dt {
            iterations += integrator.step(dt, &conditions).expect("converges").iterations;
            steps += 1;
        }
        let state = integrator.state();
        let position = state.positions[segments].coords;
        worst = worst.max((position - Vector3::new(tip[0], tip[1], 0.0)).norm());
    }
    (worst, f64::from(u32::try_from(iterations).expect("few")) / f64::from(steps))
}

#[test]
fn probe() {
    let oracle: Oracle<Swing> = common::oracle("d_planar_swing.json");
    for case in &oracle.cases {
        for rho in [1.0, 0.8, 0.5, 0.0] {
            let e: Vec<_> = [(25, 0.05), (50, 0.025), (100, 0.0125)]
                .iter()
                .map(|&(n, dt)| error(case, n, dt, rho))
                .collect();
            eprintln!(
                "{} rho {rho}: {e:.2?}  {:?}",
                case.name,
                e.iter().map(|e| format!("{:.2e}", e.0)).collect::<Vec<_>>()
            );
        }
    }
}
