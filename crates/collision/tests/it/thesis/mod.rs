//! What is kept of the thesis to compare with.

mod hierarchies;
mod scenes;
