//! Eigenvalues of stiffness and mass.

use super::Linearization;
use crate::RodError;
use nalgebra::{Complex, DVector, Vector3};
use rapunzel_linalg as linalg;

/// One small motion of a rod: `q` times `cos(omega t)`, or `exp(growth t)` where it is unstable.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// Angular frequency, rad/s; 0 for an unstable mode.
    pub angular_frequency: f64,
    /// Growth rate, 1/s; 0 for a stable mode.
    pub growth_rate: f64,
    /// Displacements of the nodes, m, world. Shapes have the modal mass 1 kg m^2.
    pub displacements: Vec<Vector3<f64>>,
    /// Rotation increments of the segments, rad, world.
    pub rotations: Vec<Vector3<f64>>,
}

impl Linearization {
    /// The `count` modes of lowest `omega^2`, unstable ones first; all of them if there are fewer.
    ///
    /// For a stable rod the largest eigenvalues of `K^-1 M` are taken, so that low frequencies
    /// are exact to rounding however high the highest is; otherwise an error of `1e-16` of the
    /// highest `omega^2` remains in each. Cost: `O(N^3)`.
    ///
    /// # Errors
    /// [`RodError::Invalid`] where the stiffness is not symmetric, see
    /// [`Linearization::characteristic_exponents`]; [`RodError::Vibration`] for a rod without
    /// inertia.
    pub fn modes(&self, count: usize) -> Result<Vec<Mode>, RodError> {
        if !self.symmetric {
            return Err(RodError::Invalid {
                what: "conditions",
                why: "moments and follower forces have no modes: use characteristic_exponents",
            });
        }
        let linalg::Modes { squares, shapes } = linalg::modes(&self.stiffness, &self.mass, count)?;
        let each = squares.iter().zip(shapes.column_iter());
        Ok(each.map(|(&square, shape)| self.mode(square, &(&self.basis * shape))).collect())
    }

    /// The `count` rates `s` of `q = Re(exp(s t) x)` that are smallest in size, one of each pair
    /// `s`, `-s`: real part growth (1/s), not negative, imaginary part frequency (rad/s). Any
    /// conditions; with follower loads, a growth beside a frequency is flutter. Cost: `O(N^3)`,
    /// some times that of [`Linearization::modes`].
    ///
    /// # Errors
    /// [`RodError::Vibration`] where the iteration for the eigenvalues does not converge.
    pub fn characteristic_exponents(&self, count: usize) -> Result<Vec<Complex<f64>>, RodError> {
        let mut rates = linalg::characteristic_exponents(&self.stiffness, &self.mass)?;
        rates.truncate(count);
        Ok(rates)
    }

    fn mode(&self, square: f64, increments: &DVector<f64>) -> Mode {
        let vectors = |x: &[f64]| x.chunks(3).map(Vector3::from_column_slice).collect();
        Mode {
            angular_frequency: square.max(0.0).sqrt(),
            growth_rate: (-square).max(0.0).sqrt(),
            displacements: vectors((&self.displacement * increments).as_slice()),
            rotations: vectors(&increments.as_slice()[if self.root_free { 3 } else { 0 }..]),
        }
    }
}
