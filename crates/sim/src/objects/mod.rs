//! Objects of a scene as things in the world.

mod mesh;
mod skeleton;
mod solid;

pub(crate) use mesh::read_mesh;
pub(crate) use solid::{Sizes, build_object};
