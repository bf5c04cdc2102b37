/// Interval of a step or of a part of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeInterval {
    /// Start, s.
    pub start: f64,
    /// Length, s.
    pub length: f64,
}
