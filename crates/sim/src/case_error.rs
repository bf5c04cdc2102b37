use std::path::PathBuf;
use thiserror::Error;

/// What is asked of a case has no answer, or its start is none.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CaseError {
    /// No length of a rod does what is wished.
    #[error(
        "no length between {shortest} and {longest} m does what is wished; allow a longer rod, or \
         wish for less"
    )]
    NoLength {
        /// The shortest length that was tried, m.
        shortest: f64,
        /// The longest, m.
        longest: f64,
    },
    /// The file that the search starts from is of no use.
    #[error("start, {}{}: {why}", path.display(), line.map_or(String::new(), |n| format!(", line {n}")))]
    Start {
        /// The file.
        path: PathBuf,
        /// Line of the file, from 1.
        line: Option<usize>,
        /// What is wrong with it.
        why: String,
    },
    /// The equilibrium does not lose its stability in the range.
    #[error(
        "the equilibrium is stable up to {last} {unit}{}",
        if *stuck {
            ", and none was found beyond; begin elsewhere, or sweep the parameter to see why"
        } else {
            ": it does not lose its stability in the range; raise `up_to`"
        }
    )]
    NotCritical {
        /// The last value of the parameter that was reached.
        last: f64,
        /// Its unit.
        unit: &'static str,
        /// Whether there is no equilibrium beyond that.
        stuck: bool,
    },
}
