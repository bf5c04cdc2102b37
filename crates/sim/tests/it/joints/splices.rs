//! Fibres that are spliced move as one.

use super::{apart, fiber, run};
use crate::common::Run;
use nalgebra::Vector3;

const METHODS: [&str; 2] = ["stepper: (dt: 2e-3)", "stepper: (dt: 2e-3, method: BackwardEuler)"];

/// A fibre that is cut in two halves and spliced moves as the whole does, with either method, to
/// the tolerance of the solver.
#[test]
fn two_halves_are_one_fibre() {
    for method in METHODS {
        let along = Vector3::new(1.0, 0.3, -0.2).normalize();
        let middle = 0.05 * along;
        let mut whole = run(&[fiber(0.1, 20, [0.0; 3], along.into(), "")], &[], method);
        let halves = [
            fiber(0.05, 10, [0.0; 3], along.into(), ""),
            fiber(0.05, 10, middle.into(), along.into(), "root_joint: Free"),
        ];
        let splice = "(hold: Spliced, first: (fiber: 0, at: Tip), second: (fiber: 1, at: Root))";
        let mut parts = run(&halves, &[splice], method);
        for step in 0..100 {
            let (own, joined) = (whole.step(), parts.step());
            if step % 20 == 0 {
                println!("iterations {} and {}", own.worst_iterations, joined.worst_iterations);
            }
        }
        let one = whole.positions(0);
        let mut two = parts.positions(0);
        let second = parts.positions(1);
        let gap = (two[10] - second[0]).norm();
        two.extend(&second[1..]);
        let off = apart(&one, &two);
        println!("{method}: apart {off:e}, open {gap:e}");
        assert!(gap < 1e-12, "{gap:e}");
        assert!(off < 1e-9, "{off:e}");
        let energy = |run: &Run| run.world.energy().total();
        let (a, b) = (energy(&whole), energy(&parts));
        assert!((a - b).abs() < 1e-9 * a.abs(), "{a:e} {b:e}");
    }
}
