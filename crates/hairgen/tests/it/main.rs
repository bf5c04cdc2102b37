//! Tests of the crate from outside.

mod balls;
mod guides;
mod hairs;
