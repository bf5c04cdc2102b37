//! Rods at rest: the answer to a [case](Case).

mod answer;
mod axis_gap;
mod branch;
mod chord_boxes;
mod contact_gaps;
mod contact_rest;
mod equilibria;
mod fixed_object;
mod length;
mod problem;
mod solve;
mod start;
mod write;

pub use crate::case_error::CaseError;
pub use answer::{
    BranchRow, CaseAnswer, CaseBranch, CaseContact, CaseEquilibrium, CaseLimit, CaseTouch, Ended,
    Length, ModeStation, Peak, Stability, Station, TouchedBy,
};
pub use rapunzel_scene::case::{
    BranchSwitch, Case, CaseEnd, CaseRod, CaseRoot, CaseStart, CaseSweep, Critical, Force,
    JoinedRod, Parameter, PlacedPoint, PointMass, SlidingHold, TouchingRod, Wish, Wished,
};
pub use solve::solve;
