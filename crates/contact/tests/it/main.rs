//! The laws and solvers of contact, and the methods of the thesis.

#![expect(clippy::print_stdout, reason = "tests tell what they measured")]

mod common;
mod laws;
mod thesis;
