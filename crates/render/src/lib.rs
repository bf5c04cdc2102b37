#![doc = include_str!("../README.md")]

mod error;
mod random;
mod ray;

pub use error::RenderError;
pub use random::PathRandom;
pub use ray::Ray;
