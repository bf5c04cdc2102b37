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

/// Known potential or charge of a conductor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Condition {
    /// Potential of the conductor, V: zero if it is earthed, that of the generator if it stands on
    /// one.
    Potential(f64),
    /// Total charge of the conductor, C: it is insulated.
    Charge(f64),
}
