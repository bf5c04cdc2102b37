//! One rod at rest: the answer to a [case](Case).

mod answer;
mod equilibria;
mod length;
mod solve;
mod write;

pub use answer::{CaseAnswer, CaseEquilibrium, Length, Peak, Stability, Station};
pub use rapunzel_scene::case::{
    Case, CaseEnd, CaseRod, Force, PlacedPoint, PointMass, Wish, Wished,
};
pub use solve::solve;
