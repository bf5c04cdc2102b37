use crate::{StrandsError, UpAxis};

/// What a reader is told about a file beyond its bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadOptions {
    /// Length of one unit of the file, m. `None`: as stated in the file; else 0.01 for USD, as its
    /// schema has it, and 1 for the other formats.
    pub meters_per_unit: Option<f64>,
    /// Axis of the file that points upward. `None`: as stated in the file; else y.
    pub up: Option<UpAxis>,
    /// Number of points of every strand of a PLY, whose points are in rows. `None`: as stated in
    /// the file.
    pub points_per_strand: Option<usize>,
    /// Time code of the sample of a USD that is read; between two samples of as many numbers it is
    /// interpolated linearly. `None`: the first.
    pub time: Option<f64>,
    /// Number of points for each segment between two control points of a cubic curve of a USD, at
    /// least 1.
    pub points_per_span: usize,
    /// Largest number of points of a strand; strands of more are refused.
    pub most_points: usize,
}

impl Default for ReadOptions {
    /// All as stated in the file; 4 points a span; at most 100,000 points a strand.
    fn default() -> Self {
        Self {
            meters_per_unit: None,
            up: None,
            points_per_strand: None,
            time: None,
            points_per_span: 4,
            most_points: 100_000,
        }
    }
}

impl ReadOptions {
    /// Checks that all values are in range.
    pub(crate) fn check(&self) -> Result<(), StrandsError> {
        let refuse = |what, value: String, must| Err(StrandsError::Option { what, value, must });
        match self.meters_per_unit {
            Some(unit) if !(unit > 0.0 && unit.is_finite()) => {
                return refuse("meters_per_unit", unit.to_string(), "positive and finite");
            }
            _ => {}
        }
        match self.time {
            Some(time) if !time.is_finite() => {
                return refuse("time", time.to_string(), "finite");
            }
            _ => {}
        }
        for (what, value) in [
            ("points_per_strand", self.points_per_strand),
            ("points_per_span", Some(self.points_per_span)),
        ] {
            if value == Some(0) {
                return refuse(what, "0".into(), "at least 1");
            }
        }
        Ok(())
    }
}
