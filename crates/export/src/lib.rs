#![doc = include_str!("../README.md")]

pub mod data;
mod error;
mod frame;
mod framing;
pub mod hair;
pub mod mitsuba;
pub mod obj;
pub mod ply;
pub mod pov;
pub mod pvd;
#[cfg(test)]
mod sample;
mod single;
pub mod surface;
mod text;
pub mod usd;
pub mod vtp;

pub use error::ExportError;
pub use frame::{Frame, Strand};
