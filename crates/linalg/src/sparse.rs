//! Sparse systems of equations. With `dense` the only file that speaks to faer.

use crate::LinalgError;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, Lu};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use nalgebra::DMatrix;

/// Largest residual of a solution in parts of the sizes that it is made of; beyond, the matrix was
/// singular to rounding.
const LARGEST_RESIDUAL: f64 = 1e-8;

/// A square sparse matrix `A` and its factors, for any number of right-hand sides.
#[derive(Debug, Clone)]
pub struct SparseSystem {
    matrix: SparseColMat<usize, f64>,
    factors: Factors,
}

#[derive(Debug, Clone)]
enum Factors {
    /// `L U`.
    Triangular(Box<Lu<usize, f64>>),
    /// `L L^T`.
    Cholesky(Llt<usize, f64>),
}

impl SparseSystem {
    /// The matrix of `size` rows with the given entries (row, column, value); entries of the same
    /// place are added. Cost: of a mesh of triangles with `n` vertices about `n^1.5` operations.
    ///
    /// # Errors
    /// [`LinalgError::Entry`] outside of the matrix, [`LinalgError::NotFinite`], and
    /// [`LinalgError::Singular`].
    pub fn new(size: usize, entries: &[(usize, usize, f64)]) -> Result<Self, LinalgError> {
        let matrix = assembled(size, entries)?;
        let factors = matrix.sp_lu().map_err(|_| LinalgError::Singular)?;
        Ok(Self { matrix, factors: Factors::Triangular(Box::new(factors)) })
    }

    /// As [`SparseSystem::new`] of a symmetric positive definite matrix, several times as fast.
    /// Entries on both sides of the diagonal are given.
    ///
    /// # Errors
    /// As [`SparseSystem::new`]; [`LinalgError::Singular`] also of a matrix that is not positive
    /// definite.
    pub fn positive_definite(
        size: usize,
        entries: &[(usize, usize, f64)],
    ) -> Result<Self, LinalgError> {
        let matrix = assembled(size, entries)?;
        let factors = matrix.sp_cholesky(Side::Lower).map_err(|_| LinalgError::Singular)?;
        Ok(Self { matrix, factors: Factors::Cholesky(factors) })
    }

    /// The solutions `X` of `A X = B`, a column for each column of `right`.
    ///
    /// # Errors
    /// [`LinalgError::Size`] for another number of rows, [`LinalgError::NotFinite`] in `right`, and
    /// [`LinalgError::Singular`] where the solution does not satisfy the equations.
    pub fn solve(&self, right: &DMatrix<f64>) -> Result<DMatrix<f64>, LinalgError> {
        let (rows, columns) = right.shape();
        let expected = self.matrix.nrows();
        if rows != expected {
            return Err(LinalgError::Size { what: "right-hand side", rows, columns, expected });
        }
        if right.iter().any(|x| !x.is_finite()) {
            return Err(LinalgError::NotFinite { what: "right-hand side" });
        }
        let b = Mat::from_fn(rows, columns, |i, j| right[(i, j)]);
        let x = match &self.factors {
            Factors::Triangular(factors) => factors.solve(&b),
            Factors::Cholesky(factors) => factors.solve(&b),
        };
        let solution = DMatrix::from_fn(rows, columns, |i, j| x[(i, j)]);
        let residual = DMatrix::from_fn(rows, columns, |i, j| b[(i, j)]) - self.product(&solution);
        let size = right.amax() + self.largest() * solution.amax();
        if residual.amax() <= LARGEST_RESIDUAL * size {
            Ok(solution)
        } else {
            Err(LinalgError::Singular)
        }
    }

    fn largest(&self) -> f64 {
        self.matrix.val().iter().fold(0.0, |most, x| x.abs().max(most))
    }

    fn product(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let mut product = DMatrix::zeros(x.nrows(), x.ncols());
        for triplet in self.matrix.triplet_iter() {
            for j in 0..x.ncols() {
                product[(triplet.row, j)] += triplet.val * x[(triplet.col, j)];
            }
        }
        product
    }
}

/// The matrix of `size` rows with the given entries.
fn assembled(
    size: usize,
    entries: &[(usize, usize, f64)],
) -> Result<SparseColMat<usize, f64>, LinalgError> {
    let mut triplets = Vec::with_capacity(entries.len());
    for &(row, column, value) in entries {
        if row >= size || column >= size {
            return Err(LinalgError::Entry { row, column, size });
        }
        if !value.is_finite() {
            return Err(LinalgError::NotFinite { what: "sparse matrix" });
        }
        triplets.push(Triplet::new(row, column, value));
    }
    SparseColMat::try_new_from_triplets(size, size, &triplets).map_err(|_| LinalgError::Singular)
}
