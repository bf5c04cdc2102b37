//! Grids of distances against exact ones, and fibers against fields.

#![expect(clippy::print_stdout, reason = "measured figures")]

#[path = "../common/mod.rs"]
mod common;
mod edge;
#[path = "../geometry/random.rs"]
mod random;
mod real;
mod scan;
mod sphere;
#[path = "../geometry/triangle.rs"]
mod triangle;
