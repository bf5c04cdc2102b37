//! Grids of distances against exact ones, and fibers against fields.

mod edge;
mod nearest;
mod real;
mod scan;
mod sphere;
