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
    /// How a fibre scatters light.
    #[error("the scattering of the fibres: {0}")]
    Scattering(#[from] ScatteringError),
}
