//! Tests of the crate from outside.

mod fit;
mod head;
mod region;
