//! Tests of the scattering of one fibre.

mod circle;
mod common;
mod ellipse;
mod far;
mod input;
mod kernel;
mod near;
mod peers;
mod raw;
