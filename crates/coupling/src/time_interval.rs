/// Interval of a step or of a part of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeInterval {
    /// Start, s.
    pub start: f64,
    /// Length, s.
    pub length: f64,
}

impl TimeInterval {
    /// An interval in which nothing moves; it has a length, as velocities are over one.
    pub(crate) fn instant(start: f64) -> Self {
        Self { start, length: 1e-12 }
    }
}
