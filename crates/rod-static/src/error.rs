use thiserror::Error;

/// What can be wrong with a static problem, or with its solution.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum StaticError {
    /// A quantity that must be positive and finite is not.
    #[error("{quantity} is {value}, but must be positive and finite; give it in SI units")]
    NotPositive {
        /// Which quantity, with its unit.
        quantity: &'static str,
        /// The value that was given.
        value: f64,
    },
    /// A quantity that must be finite is not.
    #[error("{quantity} is not finite; every number must be finite")]
    NotFinite {
        /// Which quantity.
        quantity: &'static str,
    },
    /// A rod needs at least one piece.
    #[error("the rod has no pieces; give at least one")]
    NoPieces,
    /// The end is farther from the clamp than the rod is long.
    #[error(
        "the end is {distance} m from the clamp, but the rod is {length} m long; move the end \
         nearer or make the rod longer"
    )]
    OutOfReach {
        /// Distance of the end from the clamp, m.
        distance: f64,
        /// Length of the rod, m.
        length: f64,
    },
    /// No start that was tried leads to an equilibrium.
    #[error(
        "no equilibrium was found from any start; give a start near the one that is wanted, or \
         check that the end can be reached"
    )]
    NotFound,
}

/// Checks that `value` is positive and finite.
pub(crate) fn positive(quantity: &'static str, value: f64) -> Result<(), StaticError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(StaticError::NotPositive { quantity, value })
    }
}

/// Checks that all of `values` are finite.
pub(crate) fn finite(quantity: &'static str, values: &[f64]) -> Result<(), StaticError> {
    if values.iter().all(|v| v.is_finite()) {
        Ok(())
    } else {
        Err(StaticError::NotFinite { quantity })
    }
}
