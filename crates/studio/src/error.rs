use rapunzel_export::ExportError;
use rapunzel_render::RenderError;
use rapunzel_scattering::ScatteringError;
use std::io;
use thiserror::Error;

/// Why a picture of frames cannot be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StudioError {
    /// A frame or an object that cannot be shown.
    #[error(transparent)]
    Frame(#[from] ExportError),
    /// What was given cannot be drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The look of the hair.
    #[error("the look of the hair: {0}")]
    Look(#[from] ScatteringError),
    /// A wind that cannot be shown.
    #[error("the wind {what}")]
    Wind {
        /// Description of the problem of the wind.
        what: &'static str,
    },
    /// The writer failed.
    #[error("the picture cannot be written: {0}")]
    Io(#[from] io::Error),
}
