//! A strip that is clamped above a plane and pressed onto it sticks with its tip until friction
//! cannot hold it, and slips.

use crate::common::Run;
use crate::pressed::{HANGING, PRESSING, SLIP, Strip, Stuck, slid};

#[test]
fn a_strip_sticks_until_friction_cannot_hold_its_tip() {
    for (lean, curvature, weight, way) in [
        (-10.0_f64, 1.0, 0.0, 0.15),
        (-10.0, 0.6, 0.0, 0.2),
        (5.0, 0.6, 0.0, 0.1),
        (0.0, 0.3, 20.0, 0.15),
    ] {
        let strip = Strip { lean: lean.to_radians(), curvature, weight };
        let path = strip.pressed(way).expect("it stands on its tip");
        let ratios: Vec<_> = path.iter().map(Stuck::critical).collect();
        assert!(ratios.is_sorted(), "it needs ever more friction");
        let critical = ratios[ratios.len() - 1];
        let [slips, sticks] = [0.98, 1.02].map(|share| {
            let mut run = Run::read(&strip.scene(50, way, share * critical));
            run.steps(HANGING as usize);
            let hung = run.positions(0);
            run.steps(PRESSING as usize);
            slid(&hung, &run.positions(0))
        });
        println!(
            "at {way}: slips below {critical:.4}; {slips:.2e} with 2 % less, {sticks:.2e} with 2 % more"
        );
        assert!(sticks.abs() < 10.0 * SLIP, "{sticks}");
        assert!(slips > 1e-3, "{slips}");
    }
}
