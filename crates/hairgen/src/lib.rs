#![doc = include_str!("../README.md")]

mod error;
pub mod growth;
mod pore;

pub use error::HairgenError;
pub use pore::Pore;
