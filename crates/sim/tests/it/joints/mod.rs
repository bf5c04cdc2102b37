//! Fibres that are joined to each other.

mod balls;
mod bending;
mod braid;
mod frames;
mod rings;
mod splices;
mod touching;

use crate::common::Run;

/// What fibres are made of.
const MATTER: &str = "section: Circle(radius: 5e-4),
    material: Elastic(density: 1000.0, youngs_modulus: 1e7, shear_modulus: 4e6)";

/// A fibre of a length and number of segments along a direction from a place, with other fields.
fn fiber(length: f64, segments: usize, from: [f64; 3], along: [f64; 3], more: &str) -> String {
    format!(
        "(length: {length:?}, segments: {segments}, {MATTER}{}{more},
          root: (position: {}, orientation: Along(direction: {})))",
        if more.is_empty() { "" } else { ", " },
        tuple(from),
        tuple(along)
    )
}

fn tuple([x, y, z]: [f64; 3]) -> String {
    format!("({x:?}, {y:?}, {z:?})")
}

/// A run of fibres with joints.
fn run(fibers: &[String], joints: &[&str], more: &str) -> Run {
    Run::read(&format!(
        "(format: 1, duration: 100.0, fibers: [{}], joints: [{}], {more})",
        fibers.join(", "),
        joints.join(", ")
    ))
}

/// Largest distance of two lists of nodes, m.
fn apart(a: &[nalgebra::Point3<f64>], b: &[nalgebra::Point3<f64>]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}
