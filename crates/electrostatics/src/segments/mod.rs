//! Fibres as straight charged segments.

mod near;
mod skew;
mod solver;

pub use solver::{ChargedFibers, Electrostatics};
