#![doc = include_str!("../README.md")]

mod band;
pub mod carlson;
mod chain;
pub mod elliptic;
mod energy;
mod equilibrium;
mod error;
mod goal;
mod lagrange;
mod mesh;
mod newton;
mod problem;
mod quadrature;
mod relax;
mod rod;
mod roots;
mod segment;
mod series;
mod shape;
mod shooting;
mod stability;
mod state;
mod step;
mod target;
mod trial;
mod two_phase;

pub use chain::Chain;
pub use equilibrium::Equilibrium;
pub use error::StaticError;
pub use lagrange::Lagrange;
pub use problem::Problem;
pub use relax::Rest;
pub use rod::{End, Piece, Properties};
pub use shape::Shape;
pub use state::State;
pub use target::Target;
