//! Tests of the crate from outside.

mod head;
mod region;
