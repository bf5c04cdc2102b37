#![doc = include_str!("../README.md")]

mod ball;
mod bend;
mod body;
mod chain;
mod columns;
mod contact;
mod element;
mod enclosure;
mod energy;
mod error;
mod force;
mod gradients;
mod holding;
mod implicit;
mod lattice;
mod leapfrog;
#[cfg(feature = "modes")]
mod linear;
mod newton;
mod obstacle;
mod place;
mod plastic;
mod rope;
mod runge_kutta;
mod spring;
mod stability;
mod supports;
mod system;
mod tangent;
mod wind;

pub use ball::RoundBody;
pub use bend::BendResistance;
pub use body::LatticeBody;
pub use chain::RigidChain;
pub use columns::NodeVectors;
pub use contact::{Contacts, NodeTouch, Surface, Touched};
pub use element::Element;
pub use enclosure::Enclosure;
pub use energy::SpringEnergy;
pub use error::SpringError;
pub use implicit::ImplicitEuler;
pub use lattice::{Cells, Lattice};
pub use leapfrog::Leapfrog;
#[cfg(feature = "modes")]
pub use linear::Linearized;
pub use obstacle::Obstacle;
pub use place::PlaceMatrix;
#[cfg(feature = "modes")]
pub use rapunzel_linalg::Modes;
pub use rope::Rope;
pub use runge_kutta::runge_kutta;
pub use spring::Spring;
pub use stability::StepTooLong;
pub use system::System;
pub use wind::WindField;
