//! All that a scene can set in motion.

mod charged;
mod contact;
mod free;
mod joined;
mod scenery;

pub(crate) use charged::Charged;
pub(crate) use contact::InContact;
pub(crate) use free::Free;
pub(crate) use joined::Joined;
use scenery::{NodeLoads, fiber_nodes, fiber_points, fiber_strands, fiber_values};
