use thiserror::Error;

/// What can be wrong with matrices.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum LinalgError {
    /// A matrix of the wrong size.
    #[error("the {what} is {rows} x {columns}, but must be {expected} x {expected}")]
    Size {
        /// Which matrix.
        what: &'static str,
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// Rows and columns that it must have.
        expected: usize,
    },
    /// An entry outside of a sparse matrix.
    #[error("the entry in row {row}, column {column} is outside of the matrix of {size} rows")]
    Entry {
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
        /// Rows and columns of the matrix.
        size: usize,
    },
    /// A sparse matrix without an inverse.
    #[error("the sparse matrix is singular to rounding; every unknown needs an equation")]
    Singular,
    /// A number that is not finite.
    #[error("the {what} has entries that are not finite; give finite numbers")]
    NotFinite {
        /// Of which matrix.
        what: &'static str,
    },
    /// A mass that cannot be inverted.
    #[error("the mass is not positive definite to rounding; give every coordinate some inertia")]
    Mass,
    /// The iteration for the eigenvalues did not end.
    #[error("the eigenvalues were not found; scale the coordinates so that entries are alike")]
    NotConverged,
}
