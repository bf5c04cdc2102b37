//! A conducting head.

mod boundary;
mod close;
mod elements;
mod iteration;
pub(crate) mod outside;
mod sphere;
mod thesis;
mod triangle;

pub use boundary::ConductingSurface;
pub use sphere::ConductingSphere;
pub use thesis::thesis_repulsion;

/// What is known of a conductor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Condition {
    /// Its potential, V: zero if it is earthed, that of the generator if it stands on one.
    Potential(f64),
    /// Its total charge, C: it is insulated.
    Charge(f64),
}
