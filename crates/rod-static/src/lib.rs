#![doc = include_str!("../README.md")]

pub mod carlson;
pub mod elliptic;
mod error;
mod lagrange;
mod quadrature;
mod roots;
mod state;

pub use error::StaticError;
pub use lagrange::Lagrange;
pub use state::State;
