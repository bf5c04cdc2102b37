#![doc = include_str!("../README.md")]

mod capsules;
mod closest;
mod error;
pub mod scenes;
mod wide;

pub use capsules::{Capsule, Capsules, Pair, segment_radii};
pub use closest::Closest;
pub use error::CollisionError;
pub use wide::Tree;
