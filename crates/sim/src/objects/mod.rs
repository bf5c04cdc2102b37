//! Objects of a scene as things in the world.

mod edge_capsules;
mod mesh;
mod object_builder;

pub(crate) use mesh::read_mesh;
pub(crate) use object_builder::{Sizes, build_object};
