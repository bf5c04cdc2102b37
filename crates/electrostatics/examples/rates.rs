//! Times and errors: `rates [uniform|hair] n tolerance-or-order`.
#![expect(clippy::print_stdout, reason = "it is what the example is for")]

#[path = "../tests/common/mod.rs"]
mod common;

use common::{charges, cube, hair};
use rapunzel_electrostatics::{Accuracy, ElectrostaticsError, Plan};
use std::time::Instant;

fn main() -> Result<(), ElectrostaticsError> {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let count: usize = arguments[1].parse().expect("a number of points");
    let value: f64 = arguments[2].parse().expect("a tolerance or an order");
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
    println!("{n} points: tree {planned:.2} s, repeat {again:.2} s, first {all:.2} s, {certificate:?}");
    Ok(())
}
