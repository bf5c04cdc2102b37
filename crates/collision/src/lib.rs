#![doc = include_str!("../README.md")]

mod capsules;
pub mod continuous;
mod error;
pub mod field;
mod join;
mod narrow;
mod random;
pub mod thesis;
mod triangle;
mod wide;

pub use capsules::{Capsule, Capsules, Pair, segment_radii};
pub use error::CollisionError;
pub use narrow::{
    CapsuleContact, Closest, contacts, contacts_of_groups, node_arc_lengths, squared_distances,
};
pub use wide::{Candidates, Tree, Update};
