use rapunzel_scattering::ScatteringError;
use thiserror::Error;

/// Why a picture cannot be made as asked.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A parameter that nothing can be drawn with.
    #[error("{what} is {value}, but it must be {must}")]
    Parameter {
        /// Name of the parameter, with its unit.
        what: &'static str,
        /// The value that was given.
        value: f64,
        /// Description of the values that are allowed.
        must: &'static str,
    },
    /// A fibre of which no tube can be made.
    #[error("fibre {fiber} {what}; leave it out or mend it")]
    Curve {
        /// Index of the fibre.
        fiber: usize,
        /// What is wrong with it.
        what: &'static str,
    },
    /// How a fibre scatters light.
    #[error("the scattering of the fibres: {0}")]
    Scattering(#[from] ScatteringError),
}

/// Refuses `value` unless it is `allowed`, which is false for NaN.
pub(crate) fn check(
    what: &'static str,
    value: f64,
    must: &'static str,
    allowed: bool,
) -> Result<(), RenderError> {
    if allowed { Ok(()) } else { Err(RenderError::Parameter { what, value, must }) }
}
