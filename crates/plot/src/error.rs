use plotters::drawing::DrawingAreaErrorKind;

/// A drawing that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// The library refuses an element.
    #[error("a drawing cannot be made: {0}")]
    Refused(String),
    /// `Pictures` or `Images` have no columns.
    #[error("pictures stand in no columns; give them one at least")]
    NoColumns,
    /// An image cannot be written as a PNG.
    #[error("image {caption}: {problem}; its pixels must fill its rows")]
    Image {
        /// Its caption.
        caption: String,
        /// Why.
        problem: String,
    },
}

impl<E: std::error::Error + Send + Sync> From<DrawingAreaErrorKind<E>> for PlotError {
    fn from(error: DrawingAreaErrorKind<E>) -> Self {
        Self::Refused(error.to_string())
    }
}
