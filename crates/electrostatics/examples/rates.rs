//! Times and errors: `rates uniform|hair|tress n tolerance-or-order`; the tress has n segments.
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
    let points = match arguments[0].as_str() {
        "hair" => hair(300, count / 300, 2).concat(),
        _ => cube(count, 1),
    };
    if arguments[0] == "tress" {
        return tress(count / 300, accuracy(value));
    }
    let charges = charges(points.len(), arguments[0] != "hair", 3);
    let start = Instant::now();
    let plan = Plan::new(&points, &points, accuracy(value))?;
    let planned = start.elapsed().as_secs_f64();
    let (_, certificate) = plan.fields(&charges)?;
    let all = start.elapsed().as_secs_f64();
    let (n, again) = (points.len(), all - planned);
    println!(
        "{n} points: tree {planned:.2} s, repeat {again:.2} s, first {all:.2} s, {certificate:?}"
    );
    Ok(())
}

fn accuracy(value: f64) -> Accuracy {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an order")]
    let order = value as usize;
    if value < 1.0 { Accuracy::Tolerance(value) } else { Accuracy::Order(order) }
}

/// The thesis's tress with `segments` on each of 300 fibres: time, and error against a tolerance of 1e-8.
fn tress(segments: usize, accuracy: Accuracy) -> Result<(), ElectrostaticsError> {
    let layout = rapunzel_fiber::Layout::new([segments; 300]);
    let nodes = hair(300, segments + 1, 2).concat();
    let charges = vec![7.7e-12 / segments as f64; layout.segments()];
    let radii = [40e-6; 300];
    let solve = |accuracy| {
        let start = Instant::now();
        let fibers = ChargedFibers { layout: &layout, charges: &charges, radii: &radii, accuracy };
        let result = fibers.forces(&nodes)?;
        let time = start.elapsed().as_secs_f64();
        println!("{} segments: {time:.3} s, {:?}", layout.segments(), result.certificate);
        Ok(result.forces)
    };
    for _ in 0..5 {
        solve(accuracy)?;
    }
    let error = common::relative(&solve(accuracy)?, &solve(Accuracy::Tolerance(1e-8))?);
    println!("error {error:e}");
    Ok(())
}
