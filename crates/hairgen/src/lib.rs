#![doc = include_str!("../README.md")]

mod error;
mod pore;

pub use error::HairgenError;
pub use pore::Pore;
