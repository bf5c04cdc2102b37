use rapunzel_scattering::ScatteringError;
use std::io;
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
    /// A picture without pixels, or with more than can be held.
    #[error(
        "a picture of {width} x {height} pixels cannot be held: take at least one and at most 2^28"
    )]
    PictureSize {
        /// Pixels in a row.
        width: u32,
        /// Number of rows.
        height: u32,
    },
    /// The machine has not enough memory for a picture.
    #[error("there is no memory for a picture of {width} x {height} pixels: take a smaller one")]
    PictureMemory {
        /// Pixels in a row.
        width: u32,
        /// Number of rows.
        height: u32,
    },
    /// A saved state from which a picture cannot go on.
    #[error("the saved picture cannot go on: {problem}; begin it anew")]
    PictureState {
        /// What is wrong with it.
        problem: &'static str,
    },
    /// Pixels or a file that are no map of the light of the sky.
    #[error("this is no map of the sky: {problem}")]
    SkyMap {
        /// What is wrong, and where.
        problem: String,
    },
    /// A reader or writer failed.
    #[error("the picture cannot be written or read: {0}")]
    Io(#[from] io::Error),
    /// How a fibre scatters light.
    #[error("the scattering of the fibres: {0}")]
    Scattering(#[from] ScatteringError),
}
