//! Tests of the crate from outside.

#![expect(clippy::print_stdout, reason = "tests tell what they measured")]

mod fit;
mod growth;
mod head;
mod region;
mod style;
