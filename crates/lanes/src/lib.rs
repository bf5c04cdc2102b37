#![doc = include_str!("../README.md")]

mod functions;
mod lane;
mod machine;
mod matrix;
mod quaternion;
mod real;
mod symmetric;
#[cfg(test)]
mod tests;
mod transpose;
mod vector;

pub use functions::{angle, ln};
pub use lane::{Lane, Mask, Select};
pub use machine::{Kernel, Machine, Portable, Roots, dispatch};
pub use matrix::M3;
pub use quaternion::Quat;
pub use real::Real;
pub use symmetric::Sym;
pub use transpose::Transpose;
pub use vector::V3;

/// Most lanes of any register of doubles.
pub const LANES: usize = 8;

/// Most lanes of any register of numbers of single precision.
pub const LANES_F32: usize = 2 * LANES;
