#![doc = include_str!("../README.md")]

mod barnes_hut;
mod error;
mod harmonics;
mod head;
mod lanes;
mod method;
mod multipole;
mod quadrature;
mod real;
mod segments;
pub mod units;

pub use barnes_hut::BarnesHut;
pub use error::ElectrostaticsError;
pub use harmonics::MAX_ORDER;
pub use head::{Condition, ConductingSphere, ConductingSurface, thesis_repulsion};
pub use method::{Direct, Fields, Method};
pub use multipole::{Accuracy, Certificate, Multipole, Plan};
pub use segments::{ChargedFibers, Electrostatics};
pub use units::COULOMB_CONSTANT;
