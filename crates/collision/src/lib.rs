#![doc = include_str!("../README.md")]

mod capsules;
mod closest;
pub mod continuous;
mod error;
pub mod field;
pub mod scenes;
mod triangle;

pub use capsules::{Capsule, Capsules, Pair, segment_radii};
pub use closest::Closest;
pub use error::CollisionError;
