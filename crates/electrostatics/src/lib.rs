#![doc = include_str!("../README.md")]

mod barnes_hut;
mod charging;
mod direct_sum;
mod error;
mod grid;
mod harmonics;
mod head;
mod method;
mod multipole;
mod segments;
pub mod units;
mod vectors;

pub use barnes_hut::BarnesHut;
pub use charging::{ChargeDealing, ChargeFlow};
pub use error::ElectrostaticsError;
pub use grid::FieldGrid;
pub use harmonics::MAX_ORDER;
pub use head::{Condition, ConductingSphere, ConductingSurface, thesis_repulsion};
pub use method::{Direct, Fields, Method};
pub use multipole::{Accuracy, Certificate, Multipole, MultipolePlan};
pub use segments::{ChargedFibers, Electrostatics};
pub use units::COULOMB_CONSTANT;
