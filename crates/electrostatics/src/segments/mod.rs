//! Fibres as straight charged segments.

mod columns;
mod fibers;
mod lines;
mod near;
mod pairs;
mod parallel;
mod reference;
mod rules;
mod skew;
mod solver;

pub use fibers::{ChargedFibers, Electrostatics};
