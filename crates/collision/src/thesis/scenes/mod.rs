//! Arrangements of fibres to test and to time with, each the same for the same arguments.

mod lattice;
mod models;
mod motion;

pub use lattice::{clump, wavy};
pub use models::{ball, bundle, cloth, lock, soup};
pub use motion::looping;

use crate::{Capsules, CollisionError};
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::Layout;

/// Fibres at one moment, and where they go.
#[derive(Debug, Clone, PartialEq)]
pub struct MovingFibers {
    /// Which segments belong to which fibre.
    pub layout: Layout,
    /// Positions of all nodes (world), m.
    pub positions: Vec<Point3<f64>>,
    /// What every node moves by in one step of 1 ms (world), m; zero where nothing moves.
    pub displacements: Vec<Vector3<f64>>,
    /// Radii of all segments, m.
    pub radii: Vec<f64>,
}

impl MovingFibers {
    /// The fibres as capsules.
    ///
    /// # Errors
    /// As [`Capsules::new`]; none for what the functions of this module return, unless it is empty.
    pub fn capsules(&self) -> Result<Capsules<'_>, CollisionError> {
        Capsules::new(&self.layout, &self.positions, &self.radii)
    }

    /// The same fibres `steps` steps of 1 ms later.
    #[must_use]
    pub fn advanced(&self, steps: f64) -> Self {
        let mut later = self.clone();
        for (p, d) in later.positions.iter_mut().zip(&self.displacements) {
            *p += steps * d;
        }
        later
    }
}
