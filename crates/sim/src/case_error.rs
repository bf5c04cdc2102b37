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
    /// Rods that touch something start in each other or in an object.
    #[error(
        "the axis of {} starts {} at ({:?}, {:?}, {:?}) m; move one of them, or give a `start` that \
         goes around",
        rod_name(*rod), if other < rods {
            format!("in {}", rod_name(*other))
        } else {
            format!("inside objects[{}]", other - rods)
        }, at[0], at[1], at[2]
    )]
    Overlap {
        /// Index of the rod: 0 for that of the case, and on in the order of `rods`.
        rod: usize,
        /// What it is in: a rod, or counted on, an object.
        other: usize,
        /// Number of the rods.
        rods: usize,
        /// The place, m.
        at: [f64; 3],
    },
    /// A rod in contact that nothing holds.
    #[error(
        "nothing holds {}: it can move away, or be moved, without a force, as contacts have no \
         friction; hold its root or its end, or put `objects` in its way",
        rod_name(*.0)
    )]
    Adrift(usize),
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

/// How a case names its rods.
fn rod_name(rod: usize) -> String {
    if rod == 0 { "the rod of the case".into() } else { format!("rods[{}]", rod - 1) }
}
