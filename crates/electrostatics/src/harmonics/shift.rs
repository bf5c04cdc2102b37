//! Expansions that are to be moved, and how.

use nalgebra::Vector3;

/// Operator that moves an expansion to another center.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TranslationKind {
    /// Multipole to a multipole about another center (M2M).
    Multipole,
    /// Multipole to a local expansion about another center (M2L), without what degrees below this
    /// one do to each other.
    Far(usize),
    /// Local expansion to a local expansion about another center (L2L).
    Local,
}

/// Expansion that is moved, and where to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shift<'a, E> {
    /// Coefficients of the expansion, at least up to the degree in use.
    pub(crate) coefficients: &'a [E],
    /// Degree up to which the expansion is taken, and degree of the expansion that it becomes.
    pub(crate) degrees: [usize; 2],
    /// Offset from the old center to the new one (world), m.
    pub(crate) offset: Vector3<f64>,
    /// Lengths (m) that the coefficients are scaled with, before and after.
    pub(crate) scales: [f64; 2],
}
