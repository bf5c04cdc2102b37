//! All that a scene can set in motion.

mod charged;
mod contact;
mod free;
mod scenery;

pub(crate) use charged::Charged;
pub(crate) use contact::InContact;
pub(crate) use free::Free;
use scenery::{NodeLoads, fiber_nodes, fiber_strands};
