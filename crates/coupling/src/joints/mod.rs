//! Fibres that are joined to each other, moved together.
//!
//! A joint holds two nodes together by a force that is an unknown of Newton's method beside the
//! rotations of the fibres: each iteration solves the fibres by themselves, and then for the loads
//! that close the joints, in passes over the fibres with the small system of the joints. That is
//! kept from step to step until passes with it get slow. The force acts at the end of
//! a step as the forces in segments do, so that two fibres that are spliced move as one. What is
//! between two segments that cannot turn freely is elastic, as a place within a fibre is.

mod groups;
mod joined_fibers;
mod junction;
mod matrix;
mod network;
mod node_joint;
mod step;

pub use joined_fibers::JoinedFibers;
pub(crate) use junction::Junction;
pub(crate) use node_joint::refuse_repeated;
pub use node_joint::{Connection, FiberPlace, NodeJoint};
