//! Mass-spring systems in a world: what moves in place of fibres.

mod build;
mod motion;
mod space;
mod stepper;
mod strands;

pub(crate) use stepper::MassSprings;
