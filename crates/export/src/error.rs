use std::io;
use thiserror::Error;

/// Why a frame was not written or not read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The writer or reader failed.
    #[error("the file cannot be written or read: {0}")]
    Io(#[from] io::Error),
    /// A strand has too few points, or an array of another length than its points ask for.
    #[error("strand {strand} has {found} {what}, but needs {expected}")]
    Count {
        /// Index of the strand in the frame.
        strand: usize,
        /// Elements of which array.
        what: &'static str,
        /// How many it has.
        found: usize,
        /// How many it must have.
        expected: usize,
    },
    /// A number is NaN or infinite.
    #[error("{what} of strand {strand} is not finite at index {index}; the simulation has failed")]
    NotFinite {
        /// Index of the strand in the frame.
        strand: usize,
        /// Which array.
        what: &'static str,
        /// Index in the array.
        index: usize,
    },
    /// A number is NaN, infinite, or too large for a format in single precision.
    #[error("the number {value} cannot be written in single precision; are lengths in metres?")]
    Single {
        /// The number.
        value: f64,
    },
    /// The surface of an object cannot be shown.
    #[error("a surface {what}")]
    Surface {
        /// What is wrong with it.
        what: &'static str,
    },
    /// The wind of a preview cannot be shown.
    #[error("the wind {what}")]
    Wind {
        /// What is wrong with it.
        what: &'static str,
    },
    /// The format has no room for this many.
    #[error("{found} {what}, but the format holds at most {limit}; split the frame")]
    TooMany {
        /// What is counted.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many the format can hold.
        limit: usize,
    },
    /// Frames that must share times, strands and points do not.
    #[error("frame {index} does not continue the series: {what}")]
    Series {
        /// Index of the frame.
        index: usize,
        /// How it differs.
        what: &'static str,
    },
    /// There is nothing to show.
    #[error("no frame with a strand was given; give at least one")]
    Empty,
    /// The file was not written by this module, or it is damaged.
    #[error("not a file of frames by this program: {what}")]
    Malformed {
        /// What was expected and not found.
        what: &'static str,
    },
}
