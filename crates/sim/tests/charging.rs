//! Charged fibres at rest, through the scene.

mod common;

use common::Run;
use rapunzel_electrostatics::{COULOMB_CONSTANT, units};

/// T14: two clamped fibres side by side without gravity. Their tips part by the deflection under the
/// repulsion of straight ones, T3, by the unit-load theorem; they move by 1e-4 of their distance.
#[test]
fn a_cantilever_pair_parts_by_the_closed_form() {
    let mut run = Run::read(
        "(
            format: 1, duration: 1, stepper: (dt: 1),
            environment: (gravity: (0, 0, 0)),
            fibers: [
                (length: 0.1, segments: 200, section: Circle(radius: 4e-5),
                 material: Elastic(density: 1320, youngs_modulus: 4e9, shear_modulus: 1.4e9),
                 charge: (amount: StatcoulombPerCentimeter(-7.7e-4))),
                (length: 0.1, segments: 200, section: Circle(radius: 4e-5),
                 root: (position: (0.01, 0, 0)),
                 material: Elastic(density: 1320, youngs_modulus: 4e9, shear_modulus: 1.4e9),
                 charge: (amount: StatcoulombPerCentimeter(-7.7e-4))),
            ],
            charging: (tolerance: 1e-6),
        )",
    );
    let report = run.step().charge;
    assert_eq!(report.unsettled, 0, "{report:?}");
    let (length, d) = (0.1_f64, 0.01_f64);
    let stiffness = 4e9 * std::f64::consts::PI / 4.0 * 4e-5_f64.powi(4);
    let factor = COULOMB_CONSTANT * units::THESIS_LINE_DENSITY.powi(2);
    let profile = |s: f64| factor / d * (s / s.hypot(d) + (length - s) / (length - s).hypot(d));
    let steps = 100_000;
    let at = |k: i32| length * (f64::from(k) + 0.5) / f64::from(steps);
    let load = |s: f64| profile(s) * s * s * (3.0 * length - s) / 6.0;
    let exact =
        (0..steps).map(|k| load(at(k))).sum::<f64>() * length / f64::from(steps) / stiffness;
    // In the limit of long fibres it is 1.843e-4 cm; what is missing are the ends, of the order of d/L.
    let limit = factor * length.powi(4) / (4.0 * d * stiffness);
    assert!((limit / 1.843e-6 - 1.0).abs() < 1e-3, "{limit}");
    assert!((1.0..1.0 + 2.0 * d / length).contains(&(limit / exact)), "{exact}");
    for (fiber, sign, start) in [(0, -1.0, 0.0), (1, 1.0, d)] {
        let tip = run.positions(fiber)[200];
        let moved = sign * (tip.x - start);
        // Of the first order in the segments over the distance is what the rules of the loads leave.
        assert!((moved / exact - 1.0).abs() < 1e-3, "{moved} m, not {exact}");
    }
}
