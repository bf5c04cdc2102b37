#![doc = include_str!("../README.md")]
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "programs that draw figures")]

mod page;
mod program;
mod report;

pub use page::NotRun;
pub use program::{main, main_beside};
pub use rapunzel_plot as plot;
pub use report::{ClaimCheck, Criterion, Figure, FigureEntry, check};

use std::path::PathBuf;

/// What the drawing of a figure gives, or why it fails.
pub type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

/// Why figures are not drawn.
#[derive(Debug, thiserror::Error)]
enum ReproError {
    #[error("usage: FOLDER [NUMBER OF A FIGURE ...]")]
    NoFolder,
    #[error("no such figure: {0}")]
    NoSuchFigure(String),
    #[error("figure {number}: {source}")]
    Figure { number: &'static str, source: Box<dyn std::error::Error> },
    #[error("figure {number}: {source}")]
    Drawing { number: &'static str, source: plot::PlotError },
    #[error("the manifest has no form in JSON: {0}")]
    Manifest(#[from] serde_json::Error),
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: std::io::Error },
}
