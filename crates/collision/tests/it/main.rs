//! Who touches whom: hierarchies, fields, continuous detection, against exact answers.

#![expect(clippy::print_stdout, reason = "tests tell what they measured")]

mod common;
mod continuous;
mod field;
mod geometry;
mod hairstyle;
mod step;
mod thesis;
mod wide;
