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
