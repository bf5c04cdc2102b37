//! Fibres as straight charged segments.

mod line;
mod near;
mod solver;

pub use solver::{ChargedFibers, Electrostatics};
