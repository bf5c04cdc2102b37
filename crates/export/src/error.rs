use std::io;
use thiserror::Error;

/// Why a frame was not written or not read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The writer or reader failed.
    #[error("the file cannot be written or read: {0}")]
    Io(#[from] io::Error),
    /// A strand with too few points, or with an array whose length does not match its points.
    #[error("strand {strand} has {found} {what}, but needs {expected}")]
    Count {
        /// Index of the strand in the frame.
        strand: usize,
        /// Name of the array whose elements are counted.
        what: &'static str,
        /// Number of elements of the array.
        found: usize,
        /// Number of elements that the array must have.
        expected: usize,
    },
    /// A number is NaN or infinite.
    #[error("{what} of strand {strand} is not finite at index {index}; the simulation has failed")]
    NotFinite {
        /// Index of the strand in the frame.
        strand: usize,
        /// Name of the array.
        what: &'static str,
        /// Index in the array.
        index: usize,
    },
    /// A number is NaN, infinite, or too large for a format in single precision.
    #[error("the number {value} cannot be written in single precision; are lengths in metres?")]
    Single {
        /// The number that does not fit.
        value: f64,
    },
    /// A surface of an object that cannot be shown.
    #[error("a surface {what}")]
    Surface {
        /// Description of the problem of the surface.
        what: &'static str,
    },
    /// A look that no hair has.
    #[error("the look of hair has {what}")]
    Look {
        /// Description of the problem of the look.
        what: &'static str,
    },
    /// A count that exceeds what the format can hold.
    #[error("{found} {what}, but the format holds at most {limit}; split the frame")]
    TooMany {
        /// Name of what is counted.
        what: &'static str,
        /// Count that was found.
        found: usize,
        /// Largest count that the format can hold.
        limit: usize,
    },
    /// Frames of a series that differ in times, strands or points.
    #[error("frame {index} does not continue the series: {what}")]
    Series {
        /// Index of the frame that differs.
        index: usize,
        /// Description of the difference.
        what: &'static str,
    },
    /// A frame or series with nothing to show.
    #[error("no frame with a strand was given; give at least one")]
    Empty,
    /// A file that was not written by this module, or is damaged.
    #[error("not a file of frames by this program: {what}")]
    Malformed {
        /// Name of what was expected and not found.
        what: &'static str,
    },
}
