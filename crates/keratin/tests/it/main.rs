//! Tables, laws and instruments of hair.

mod common;
mod laboratory;
mod laws;
mod rods;
mod tables;
