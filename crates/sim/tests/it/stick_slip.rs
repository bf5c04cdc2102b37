//! Stick and slip on a belt.

use crate::belt::{Belt, angle};
use crate::common::Run;
use std::convert::Infallible;

#[test]
fn a_belt_makes_a_hair_stick_and_slip() {
    let belt = Belt::new();
    let tip = |run: &Run| run.world.node(0, None).0;
    let mut run = Run::read(&belt.scene(angle(&tip(&Run::read(&belt.scene(0.0))))));
    let next = || {
        run.step();
        Ok::<_, Infallible>(tip(&run))
    };
    let times = belt.crossings(next, |_, _| ()).expect("steps");
    let (found, period) = (times[1] - times[0], belt.period);
    println!("{:.4} ms for {:.4} ms", 1e3 * found, 1e3 * period);
    assert!((found / period - 1.0).abs() < 5e-3, "{found} for {period}");
}
