use thiserror::Error;

/// Errors of the description of a fibre.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FiberError {
    /// A quantity that must be positive and finite is not.
    #[error("{quantity} is {value}, but must be positive and finite; give it in SI units")]
    NotPositive {
        /// Name of the quantity, with its unit.
        quantity: &'static str,
        /// The value that was given.
        value: f64,
    },
    /// A quantity that must be finite is not.
    #[error("{quantity} at index {index} is not finite; every number must be finite")]
    NotFinite {
        /// Name of the quantity.
        quantity: &'static str,
        /// Index of the node or segment.
        index: usize,
    },
    /// A fibre needs at least one segment.
    #[error("the fibre has no segments; give at least one")]
    NoSegments,
    /// There must be one more node than segments.
    #[error("{segments} segments need {} nodes, but {nodes} were given", segments + 1)]
    NodeCount {
        /// Number of segments.
        segments: usize,
        /// Number of nodes that were given.
        nodes: usize,
    },
    /// A number lies outside of the range in which it has a meaning.
    #[error("{quantity} is {value}, but must lie in {range}")]
    OutOfRange {
        /// Name of the quantity, with its unit.
        quantity: &'static str,
        /// The value that was given.
        value: f64,
        /// The allowed range, as text.
        range: &'static str,
    },
    /// A direction was given by a vector that has none: zero, or not finite.
    #[error("{quantity} is zero or not finite and so has no direction; give any other vector")]
    NoDirection {
        /// Name of the vector.
        quantity: &'static str,
    },
    /// Two consecutive points of a curve coincide.
    #[error("points {index} and {} of the curve are the same; leave one out", index + 1)]
    Coincident {
        /// Index of the first of the two; one past the last point is the first of a closed curve.
        index: usize,
    },
    /// A curve is longer or shorter than the fibre that is to be laid along it.
    #[error(
        "the curve is {found} m long, but the fibre {wanted} m: give the fibre that length, or \
         scale the curve by {}",
        wanted / found
    )]
    CurveLength {
        /// Length of the curve, m.
        found: f64,
        /// Length of the fibre, m.
        wanted: f64,
    },
    /// The segments are too long for the curve that they are to follow.
    #[error(
        "{segments} segments cannot follow the curve; give at least {needed}, or a curve that \
         bends less"
    )]
    Unresolved {
        /// Number of segments that was given.
        segments: usize,
        /// Number of segments that resolves the curve barely, rounded up.
        needed: f64,
    },
}

/// Checks that `value` is positive and finite.
pub(crate) fn positive(quantity: &'static str, value: f64) -> Result<(), FiberError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(FiberError::NotPositive { quantity, value })
    }
}

/// Checks that `value` is at least zero and finite.
pub(crate) fn not_negative(quantity: &'static str, value: f64) -> Result<(), FiberError> {
    if value >= 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(FiberError::OutOfRange { quantity, value, range: "[0, infinity)" })
    }
}

/// Checks that `value` lies in `[0, 1]`.
pub(crate) fn fraction(quantity: &'static str, value: f64) -> Result<(), FiberError> {
    if (0.0..=1.0).contains(&value) {
        Ok(())
    } else {
        Err(FiberError::OutOfRange { quantity, value, range: "[0, 1]" })
    }
}
