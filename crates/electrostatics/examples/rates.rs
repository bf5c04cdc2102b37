//! Times and errors: `rates uniform|hair|tress|half-head n tolerance-or-order`; the tress has n
//! segments, the half head n hairs of 100 segments.
#![expect(clippy::print_stdout, reason = "it is what the example is for")]

#[allow(dead_code, reason = "it takes what it needs")]
#[path = "../tests/it/common/mod.rs"]
mod common;

use common::{charges, cube, hair};
use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::{Mesh, shapes};
use rapunzel_electrostatics::{
    Accuracy, ChargedFibers, Condition, ConductingSurface, ElectrostaticsError, MultipolePlan,
};
use std::time::Instant;

fn main() -> Result<(), ElectrostaticsError> {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let count: usize = arguments[1].parse().expect("a number of points");
    let value: f64 = arguments[2].parse().expect("a tolerance or an order");
    if arguments[0] == "tress" {
        return tress(count / 300, accuracy(value));
    }
    if arguments[0] == "half-head" {
        return half_head(count, accuracy(value));
    }
    let points = match arguments[0].as_str() {
        "hair" => hair(300, count / 300, 2).concat(),
        _ => cube(count, 1),
    };
    let charges = charges(points.len(), arguments[0] != "hair", 3);
    let start = Instant::now();
    let plan = MultipolePlan::new(&points, &points, accuracy(value))?;
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

/// The thesis's tress with `segments` on each of 300 fibres: time, and error against a tolerance of
/// 1e-8.
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

/// `count` hairs of 10 cm and 100 segments on half of a conducting ball of 9 cm, which hang down
/// more the farther they are from it: the times of all forces.
fn half_head(count: usize, accuracy: Accuracy) -> Result<(), ElectrostaticsError> {
    let layout = rapunzel_fiber::Layout::new(vec![100; count]);
    let hair = |k: usize| {
        // Vogel's spiral on the sphere, of which half is taken.
        let (z, angle) = (1.0 - (k as f64 + 0.5) / count as f64, 2.399_963_229_728_653 * k as f64);
        let radius = (1.0 - z * z).sqrt();
        let root = Vector3::new(radius * angle.cos(), radius * angle.sin(), z);
        let node = move |i: u32| {
            let s = 1e-3 * f64::from(i);
            Point3::from(
                0.0905 * root + (root + Vector3::new(0.0, 0.0, 0.3 - 6.0 * s)).normalize() * s,
            )
        };
        (0..=100).map(node)
    };
    let nodes: Vec<_> = (0..count).flat_map(hair).collect();
    let (charges, radii) = (vec![7.7e-14; layout.segments()], vec![40e-6; count]);
    let start = Instant::now();
    let mesh = Mesh::new(shapes::sphere(0.09, 16)).expect("a closed surface");
    let head = ConductingSurface::new(&mesh)?;
    println!("{} triangles: {:.2} s", head.centers().len(), start.elapsed().as_secs_f64());
    let start = Instant::now();
    let fibers = ChargedFibers { layout: &layout, charges: &charges, radii: &radii, accuracy };
    let result = fibers.forces_beside(&nodes, &head, Condition::Charge(0.0))?;
    println!(
        "{} segments: {:.2} s, {:?}",
        layout.segments(),
        start.elapsed().as_secs_f64(),
        result.certificate
    );
    Ok(())
}
