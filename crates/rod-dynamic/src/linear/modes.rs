//! Eigenvalues of stiffness and mass.

use super::Linearization;
use crate::RodError;
use nalgebra::{Complex, DMatrix, DVector, Schur, Vector3};

/// A stiffness with a smaller pivot, in parts of the largest, has a motion that costs no energy.
const STIFF: f64 = 1e-12;

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
    /// [`Linearization::characteristic_exponents`].
    pub fn modes(&self, count: usize) -> Result<Vec<Mode>, RodError> {
        if !self.symmetric {
            return Err(RodError::Invalid {
                what: "conditions",
                why: "moments and follower forces have no modes: use characteristic_exponents",
            });
        }
        let (squares, shapes) = match reduce(&self.stiffness, &self.mass, STIFF) {
            Some((inverses, shapes)) => (inverses.map(|x| 1.0 / x), shapes),
            None => reduce(&self.mass, &self.stiffness, 0.0).ok_or(SINGULAR)?,
        };
        let mut order: Vec<_> = (0..squares.len()).collect();
        order.sort_by(|&i, &j| squares[i].total_cmp(&squares[j]));
        order.truncate(count);
        Ok(order.into_iter().map(|i| self.mode(squares[i], &shapes.column(i).into())).collect())
    }

    /// The `count` rates `s` of `q = Re(exp(s t) x)` that are smallest in size, one of each pair
    /// `s`, `-s`: real part growth (1/s), not negative, imaginary part frequency (rad/s). Any
    /// conditions; with follower loads, a growth beside a frequency is flutter. Cost: `O(N^3)`,
    /// ten times that of [`Linearization::modes`].
    ///
    /// # Errors
    /// [`RodError::Invalid`] where the iteration for the eigenvalues does not converge.
    pub fn characteristic_exponents(&self, count: usize) -> Result<Vec<Complex<f64>>, RodError> {
        // As in `modes`, the inverse gives the low ones exactly.
        let (matrix, inverse) = match self.stiffness.clone().lu().solve(&self.mass) {
            Some(matrix) if matrix.iter().all(|x| x.is_finite()) => (matrix, true),
            _ => (self.mass.clone().cholesky().ok_or(SINGULAR)?.solve(&self.stiffness), false),
        };
        let sweeps = 100 * matrix.nrows();
        let schur = Schur::try_new(matrix, f64::EPSILON, sweeps).ok_or(RodError::Invalid {
            what: "state",
            why: "the eigenvalues of its stiffness were not found",
        })?;
        let squares = schur.complex_eigenvalues();
        let rate = |x: &Complex<f64>| {
            let s = if inverse { -x.inv() } else { -x }.sqrt();
            Complex::new(s.re.abs(), s.im.abs())
        };
        let mut rates: Vec<_> = squares.iter().map(rate).collect();
        rates.sort_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr()));
        rates.truncate(count);
        Ok(rates)
    }

    fn mode(&self, square: f64, shape: &DVector<f64>) -> Mode {
        let modal_mass = shape.dot(&(&self.mass * shape));
        let increments = &self.basis * shape / modal_mass.sqrt();
        let vectors = |x: &[f64]| x.chunks(3).map(Vector3::from_column_slice).collect();
        Mode {
            angular_frequency: square.max(0.0).sqrt(),
            growth_rate: (-square).max(0.0).sqrt(),
            displacements: vectors((&self.displacement * &increments).as_slice()),
            rotations: vectors(&increments.as_slice()[if self.root_free { 3 } else { 0 }..]),
        }
    }
}

/// Eigenvalues of `a^-1 b` and their vectors, for an `a` whose pivots are positive and all larger
/// than the part `pivot` of the largest.
fn reduce(a: &DMatrix<f64>, b: &DMatrix<f64>, pivot: f64) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let lower = a.clone().cholesky()?.unpack();
    let roots = lower.diagonal();
    if roots.min() <= pivot.sqrt() * roots.max() {
        return None;
    }
    let half = lower.solve_lower_triangular(b)?;
    let c = lower.solve_lower_triangular(&half.transpose())?;
    let eigen = c.symmetric_eigen();
    Some((eigen.eigenvalues, lower.tr_solve_lower_triangular(&eigen.eigenvectors)?))
}

/// What a mass that is not positive definite says.
const SINGULAR: RodError = RodError::Invalid {
    what: "mass",
    why: "not positive definite to rounding: the rotary inertia is too small to invert it",
};
