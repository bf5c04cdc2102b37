//! What a user asks of one rod at rest: the case.
//!
//! A case is a RON file like a scene: SI units, angles in degrees, the world frame; unknown fields
//! and numbers that make no sense are errors. Its rod is clamped at its root, loaded along its
//! length, and its far end is free, in a joint, in a bearing, or clamped.

mod answer;
mod case;
mod length;
mod solve;
mod write;

pub use answer::{Answer, Equilibrium, Length, Peak, Stability, Station};
pub use case::{Case, End, Force, Mass, Place, Rod, Wish, Wished};
