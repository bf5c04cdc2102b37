//! Where two capsules touch.

mod batch;
mod closest;
mod contact;
mod distance;

pub use closest::Closest;
pub use contact::{CapsuleContact, contacts, contacts_of_groups, node_arc_lengths};
pub use distance::squared_distances;
