use thiserror::Error;

/// What can be wrong with the description of a fibre.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FiberError {
    /// A quantity that must be positive and finite is not.
    #[error("{quantity} is {value}, but must be positive and finite; give it in SI units")]
    NotPositive {
        /// Which quantity, with its unit.
        quantity: &'static str,
        /// The value that was given.
        value: f64,
    },
    /// A quantity that must be finite is not.
    #[error("{quantity} at index {index} is not finite; every number must be finite")]
    NotFinite {
        /// Which quantity.
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
}

/// Checks that `value` is positive and finite.
pub(crate) fn positive(quantity: &'static str, value: f64) -> Result<(), FiberError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(FiberError::NotPositive { quantity, value })
    }
}
