use rapunzel_fiber::FiberError;
use thiserror::Error;

/// Why light on a fibre cannot be computed as asked.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ScatteringError {
    /// A parameter that no model can use.
    #[error("{what} is {value}, but it must be {must}")]
    Parameter {
        /// Name of the parameter, with its unit.
        what: &'static str,
        /// The value that was given.
        value: f64,
        /// Description of the values that are allowed.
        must: &'static str,
    },
    /// Polarisation is to be tracked through an ellipse.
    #[error(
        "polarisation is tracked through circles only: inside an ellipse light can be reflected \
         totally, which turns linear polarisation into elliptic; average it, or take a circle"
    )]
    TrackedEllipse,
    /// A cross section that is none.
    #[error("the cross section of the fibre: {0}")]
    Section(#[from] FiberError),
}

/// Refuses `value` unless it is `allowed`, which is false for NaN.
pub(crate) fn check(
    what: &'static str,
    value: f64,
    must: &'static str,
    allowed: bool,
) -> Result<(), ScatteringError> {
    if allowed { Ok(()) } else { Err(ScatteringError::Parameter { what, value, must }) }
}
