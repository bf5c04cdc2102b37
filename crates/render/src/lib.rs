#![doc = include_str!("../README.md")]

mod curves;
mod error;
mod random;
mod ray;
mod tree;

pub use curves::{CurveBasis, CurveHit, Curves, FiberCurve, TubePoint};
pub use error::RenderError;
pub use random::PathRandom;
pub use ray::Ray;
