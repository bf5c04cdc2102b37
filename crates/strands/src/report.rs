use std::fmt;

/// What a reader found, took for granted and left out.
#[derive(Debug, Clone, PartialEq)]
pub struct StrandReport {
    /// Name of the format.
    pub format: &'static str,
    /// Number of strands in the file.
    pub found: usize,
    /// Length of one unit of the file, m.
    pub meters_per_unit: Known<f64>,
    /// Axis of the file that points upward.
    pub up: Known<UpAxis>,
    /// Number of points that were dropped because they equal the one before.
    pub merged: usize,
    /// Strands that cannot be hairs and were left out: number in the file, from 0, and the reason.
    pub refused: Vec<(usize, StrandFault)>,
    /// Other parts of the file that may hold strands and were not read.
    pub unread: Vec<String>,
}

/// A value with its origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known<T> {
    /// The value.
    pub value: T,
    /// Who said so.
    pub origin: Origin,
}

/// Who said what a file itself may leave open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// The caller, whose word goes before that of the file.
    Given,
    /// The file.
    Stated,
    /// Nobody: it is what is usual for the format.
    Assumed,
}

/// Axis of a file that points upward.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UpAxis {
    /// The second.
    Y,
    /// The third.
    Z,
}

/// Why a strand of a file cannot be a hair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum StrandFault {
    /// It has no or one point.
    FewPoints,
    /// It has points, but all are equal.
    NoLength,
    /// It has a coordinate that is NaN, infinite or too large.
    NotFinite,
    /// It has a radius that is NaN, infinite or negative.
    Radius,
    /// It has more points than allowed by
    /// [`ReadOptions::most_points`](crate::ReadOptions::most_points).
    ManyPoints,
    /// Its number of control points does not suit its basis.
    ControlPoints,
    /// It has a point between more than two edges.
    Branch,
    /// Its edges form a ring without a root.
    Ring,
}

/// All faults, in the order of a report, with their words.
const FAULTS: [(StrandFault, &str); 8] = [
    (StrandFault::FewPoints, "fewer than two points"),
    (StrandFault::NoLength, "no length"),
    (StrandFault::NotFinite, "a point that is NaN, infinite or too large"),
    (StrandFault::Radius, "a radius that is NaN, infinite or negative"),
    (StrandFault::ManyPoints, "more points than allowed"),
    (StrandFault::ControlPoints, "a number of points that does not suit the basis"),
    (StrandFault::Branch, "a branch"),
    (StrandFault::Ring, "no end"),
];

/// Most numbers of strands that are listed for a fault.
const LISTED: usize = 8;

/// A few lines, however many strands were refused: for every reason their count and first numbers.
impl fmt::Display for StrandReport {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let taken = self.found - self.refused.len();
        write!(out, "{}: {taken} of {} strands", self.format, self.found)?;
        let Known { value, origin } = self.meters_per_unit;
        write!(out, "; 1 unit is {value} m ({origin}), ")?;
        write!(out, "{:?} is up ({})", self.up.value, self.up.origin)?;
        if self.merged > 0 {
            write!(out, "\n{} points dropped that equal the one before", self.merged)?;
        }
        for (fault, words) in FAULTS {
            let numbers =
                self.refused.iter().filter(|(_, f)| *f == fault).map(|(number, _)| number);
            let count = numbers.clone().count();
            if count > 0 {
                write!(out, "\n{count} left out with {words}:")?;
                numbers.take(LISTED).try_for_each(|number| write!(out, " {number}"))?;
                if count > LISTED {
                    write!(out, " and {} more", count - LISTED)?;
                }
            }
        }
        for part in self.unread.iter().take(LISTED) {
            write!(out, "\nnot read: {part}")?;
        }
        if self.unread.len() > LISTED {
            write!(out, "\nnot read: {} more", self.unread.len() - LISTED)?;
        }
        Ok(())
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::Given => "as given",
            Self::Stated => "stated in the file",
            Self::Assumed => "assumed",
        })
    }
}
