#![doc = include_str!("../README.md")]

pub mod carlson;
pub mod elliptic;
mod equilibrium;
mod error;
mod goal;
mod lagrange;
mod mesh;
mod problem;
mod quadrature;
mod rod;
mod roots;
mod shooting;
mod stability;
mod state;
mod step;

pub use equilibrium::Equilibrium;
pub use error::StaticError;
pub use lagrange::Lagrange;
pub use problem::Problem;
pub use rod::{End, Piece, Properties};
pub use state::State;
