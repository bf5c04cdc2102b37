//! The fast multipole method.

pub(crate) mod accuracy;
pub(crate) mod downward;
mod points;
mod reference;
pub(crate) mod samples;
mod single;
pub(crate) mod solver;
pub(crate) mod tree;
pub(crate) mod upward;

pub use accuracy::Accuracy;
pub use solver::{Certificate, Multipole, MultipolePlan};
