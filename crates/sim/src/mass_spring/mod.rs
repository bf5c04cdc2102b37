//! Mass-spring systems in a world: one that moves in place of fibres.

mod build;
mod motion;
mod strands;

pub(crate) use build::{build, readings};
pub use motion::MassSprings;
pub(crate) use motion::Springs;
