#![doc = include_str!("../README.md")]

mod bend;
mod columns;
mod error;
mod force;
mod implicit;
mod leapfrog;
mod linear;
mod newton;
mod runge_kutta;
mod spring;
mod supports;
mod system;
mod tangent;
mod wind;

pub use bend::Bend;
pub use columns::Columns;
pub use error::SpringError;
pub use implicit::ImplicitEuler;
pub use leapfrog::Leapfrog;
pub use linear::{Linearized, Modes, StepTooLong};
pub use runge_kutta::runge_kutta;
pub use spring::Spring;
pub use system::{Energy, System};
pub use wind::Wind;
