#![doc = include_str!("../README.md")]

mod error;
mod frame;
pub mod hair;
pub mod pov;
pub mod preview;
pub mod pvd;
#[cfg(test)]
mod sample;
pub mod surface;
pub mod usd;
pub mod vtp;

pub use error::ExportError;
pub use frame::{Frame, Strand};
