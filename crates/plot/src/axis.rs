use crate::ticks::{label, ticks};
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use std::ops::Range;

/// An axis for the library, with marks at round numbers.
pub(crate) struct PlotAxis {
    ends: RangedCoordf64,
    marks: Vec<f64>,
    /// Between marks.
    step: f64,
    /// Whether its numbers are powers of ten.
    log: bool,
}

impl PlotAxis {
    /// An axis between two ends, with at most some `most` marks.
    pub(crate) fn new([low, high]: [f64; 2], most: f64, log: bool) -> Self {
        let (mut marks, step) = ticks([low, high], most);
        if log {
            marks.retain(|power| (power - power.round()).abs() < 1e-9);
        }
        Self { ends: (low..high).into(), marks, step, log }
    }
}

impl Ranged for PlotAxis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.ends.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        // Light ones are those between marks, of which there are none.
        if hint.weight().allow_light_points() { Vec::new() } else { self.marks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.ends.range()
    }
}

impl ValueFormatter<f64> for PlotAxis {
    fn format_ext(&self, value: &f64) -> String {
        if self.log { format!("1e{value:.0}") } else { label(*value, self.step) }
    }
}
