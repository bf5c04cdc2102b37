//! Random places and triangles.

pub(crate) mod random;
pub(crate) mod triangle;
