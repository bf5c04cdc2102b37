use thiserror::Error;

/// Why strands were not read, or not changed as asked.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum StrandsError {
    /// A file whose format cannot be told from its bytes.
    #[error("the format cannot be told from the bytes; name it: hair, data, usd, ply or obj")]
    Unknown,
    /// A file that is shorter than its own counts tell.
    #[error(
        "{format}: cut off at byte {at}: {what} should take {needed} bytes, but {left} are left; \
         copy or write the file again"
    )]
    CutOff {
        /// Name of the format.
        format: &'static str,
        /// Name of the part that is not whole.
        what: &'static str,
        /// Offset of the part from the start of the file, bytes.
        at: usize,
        /// Size of the part, bytes.
        needed: usize,
        /// Size of what is there of it, bytes.
        left: usize,
    },
    /// A file that breaks the rules of its format.
    #[error("{format}: {place}: {problem}")]
    Read {
        /// Name of the format.
        format: &'static str,
        /// Where in the file: a line, a byte or a prim.
        place: String,
        /// What is wrong there, and what can be done.
        problem: String,
    },
    /// A value that a reader or a method was given and cannot use.
    #[error("{what} is {value}, but it must be {must}")]
    Option {
        /// Name of the value.
        what: &'static str,
        /// The value that was given.
        value: String,
        /// Description of the values that are allowed.
        must: &'static str,
    },
    /// A resampling that cannot be as near as is asked for.
    #[error(
        "{most} segments a strand are {error} m off at strand {strand}, but {tolerance} m are \
         asked for; allow more segments"
    )]
    Tolerance {
        /// Largest number of segments that was allowed.
        most: usize,
        /// Index of the strand that is farthest off.
        strand: usize,
        /// Its distance, m.
        error: f64,
        /// Distance that was asked for, m.
        tolerance: f64,
    },
    /// A resampling with two equal points in a row, of a strand that folds back on itself.
    #[error(
        "strand {strand} folds back on itself and has a segment without length when it is made \
         of {segments}; take another number of segments"
    )]
    Fold {
        /// Index of the strand.
        strand: usize,
        /// Number of segments that was asked for.
        segments: usize,
    },
}
