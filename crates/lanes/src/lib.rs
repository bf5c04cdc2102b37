#![doc = include_str!("../README.md")]

mod equal;
mod finite;
mod functions;
mod lane;
mod machine;
mod matrix;
mod quaternion;
mod real;
mod roots;
mod symmetric;
#[cfg(test)]
mod tests;
mod transpose;
mod vector;
mod ways;

pub use equal::all_equal;
pub use finite::all_finite;
pub use functions::{angle, ln};
pub use lane::{Lane, Mask, Select};
pub use machine::{Kernel, Machine, dispatch};
pub use matrix::M3;
pub use quaternion::Quat;
pub use real::{LANES, LANES_F32, Real};
pub use roots::{Portable, Roots};
pub use symmetric::Sym;
pub use transpose::Transpose;
pub use vector::V3;
pub use ways::Ways;
