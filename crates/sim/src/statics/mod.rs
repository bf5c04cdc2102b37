//! One rod at rest: the answer to a [case](Case).

mod answer;
mod branch;
mod equilibria;
mod length;
mod problem;
mod solve;
mod start;
mod write;

pub use crate::case_error::CaseError;
pub use answer::{
    BranchRow, CaseAnswer, CaseBranch, CaseEquilibrium, CaseLimit, Ended, Length, ModeStation,
    Peak, Stability, Station,
};
pub use rapunzel_scene::case::{
    Case, CaseEnd, CaseRod, CaseRoot, CaseStart, CaseSweep, Critical, Force, JoinedRod, Parameter,
    PlacedPoint, PointMass, SlidingHold, Wish, Wished,
};
pub use solve::solve;
