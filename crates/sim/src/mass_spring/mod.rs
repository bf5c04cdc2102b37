//! Mass-spring systems in a world: what moves in place of fibres.

mod build;
mod motion;
mod strands;

pub(crate) use motion::MassSprings;
