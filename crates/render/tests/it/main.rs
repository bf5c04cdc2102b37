//! Tests of the scattering of one fibre.

mod circle;
mod common;
mod ellipse;
mod models;
