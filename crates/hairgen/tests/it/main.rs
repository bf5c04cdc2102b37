//! Tests of the crate from outside.

#![expect(clippy::print_stdout, reason = "tests tell what they measured")]

mod bad_style;
mod balls;
mod fit;
mod growth;
mod guides;
mod hairs;
mod head;
mod region;
mod style;
