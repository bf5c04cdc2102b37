#![doc = include_str!("../README.md")]

mod capsules;
pub mod continuous;
mod error;
pub mod field;
pub mod hierarchy;
mod join;
mod narrow;
pub mod packing;
mod random;
pub mod scenes;
mod triangle;
pub mod volume;
mod wide;

pub use capsules::{Capsule, Capsules, Pair, segment_radii};
pub use error::CollisionError;
pub use narrow::{
    CapsuleContact, Closest, contacts, contacts_of_groups, node_arc_lengths, squared_distances,
};
pub use wide::{Candidates, Tree, Update};
