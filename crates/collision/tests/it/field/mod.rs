//! Grids of distances against exact ones, and fibers against fields.

mod edge;
mod real;
mod scan;
mod sphere;
