//! The fast multipole method.

pub(crate) mod engine;
pub(crate) mod near;
mod points;
mod reference;
pub(crate) mod samples;
mod single;
pub(crate) mod solver;
pub(crate) mod tree;

pub use solver::{Accuracy, Certificate, Multipole, Plan};
