//! Times and errors: `rates uniform|hair n tolerance-or-order`, or `rates tress
//! points-on-a-segment tolerance`.
#![expect(clippy::print_stdout, reason = "it is what the example is for")]

#[path = "../tests/common/mod.rs"]
mod common;

use common::{charges, cube, hair};
use rapunzel_electrostatics::{Accuracy, ChargedFibers, ElectrostaticsError, Plan};
use std::time::Instant;

fn main() -> Result<(), ElectrostaticsError> {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let count: usize = arguments[1].parse().expect("a number of points");
    let value: f64 = arguments[2].parse().expect("a tolerance or an order");
    if arguments[0] == "tress" {
        return tress(count, value);
    }
    let points = match arguments[0].as_str() {
        "hair" => hair(300, count / 300, 2).concat(),
        _ => cube(count, 1),
    };
    let charges = charges(points.len(), arguments[0] != "hair", 3);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an order")]
    let accuracy =
        if value < 1.0 { Accuracy::Tolerance(value) } else { Accuracy::Order(value as usize) };
    let start = Instant::now();
    let plan = Plan::new(&points, &points, accuracy)?;
    let planned = start.elapsed().as_secs_f64();
    let (_, certificate) = plan.fields(&charges)?;
    let all = start.elapsed().as_secs_f64();
    let (n, again) = (points.len(), all - planned);
    println!(
        "{n} points: tree {planned:.2} s, repeat {again:.2} s, first {all:.2} s, {certificate:?}"
    );
    Ok(())
}

/// The thesis's tress as 30,000 segments: time, and error against twice and four times as many points
/// on each segment.
fn tress(points: usize, tolerance: f64) -> Result<(), ElectrostaticsError> {
    let layout = rapunzel_fiber::Layout::new([100; 300]);
    let nodes = hair(300, 101, 2).concat();
    let charges = vec![7.7e-14; layout.segments()];
    let radii = [40e-6; 300];
    let solve = |points: usize, tolerance: f64| {
        let start = Instant::now();
        let accuracy = Accuracy::Tolerance(tolerance);
        let fibers =
            ChargedFibers { layout: &layout, charges: &charges, radii: &radii, points, accuracy };
        let result = fibers.forces(&nodes)?;
        println!(
            "{points} points: {:.3} s, {:?}",
            start.elapsed().as_secs_f64(),
            result.certificate
        );
        Ok(result.forces)
    };
    solve(points, tolerance)?;
    let forces = solve(points, tolerance)?;
    for finer in [8, 16, 24] {
        let exact = solve(finer, 1e-7)?;
        println!("error {:e}", common::relative(&forces, &exact));
    }
    Ok(())
}
