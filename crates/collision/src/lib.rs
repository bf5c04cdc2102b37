#![doc = include_str!("../README.md")]

mod capsules;
mod closest;
mod error;
pub mod hierarchy;
pub mod packing;
mod random;
pub mod scenes;
pub mod volume;

pub use capsules::{Capsule, Capsules, Pair, segment_radii};
pub use closest::Closest;
pub use error::CollisionError;
