use nalgebra::Point3;
use rapunzel_export::{ExportError, Frame, Strand};

/// The data of a frame that a sheet shows.
#[derive(Debug, Clone, PartialEq)]
pub struct PreviewFrame {
    /// Simulated time, s.
    pub time: f64,
    pub(super) lines: Vec<Line>,
    pub(super) supports: Vec<Support>,
}

/// A support of a point of a strand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Support {
    /// Index of the strand in the frame.
    pub strand: usize,
    /// Index of the point in the strand.
    pub point: usize,
    /// Whether the strand cannot rotate there: a clamp is drawn as a bar across it, a joint as a
    /// ring.
    pub clamped: bool,
}

/// A fibre in single precision: its points (world) and the radii there, m, to a small fraction of a
/// pixel.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Line {
    pub(super) points: Vec<Point3<f32>>,
    pub(super) radii: Vec<f32>,
}

impl Line {
    pub(super) fn points(&self) -> impl Iterator<Item = Point3<f64>> + Clone {
        self.points.iter().map(|point| point.cast())
    }
}

impl PreviewFrame {
    /// Keeps what a sheet shows of a frame and of the supports of its strands: a tenth of its
    /// bytes.
    ///
    /// # Errors
    /// Refuses invalid frames, and supports of points that do not exist.
    pub fn new(frame: Frame, supports: Vec<Support>) -> Result<Self, ExportError> {
        frame.validate()?;
        let there = |support: &Support| {
            frame.strands.get(support.strand).is_some_and(|s| support.point < s.points.len())
        };
        if !supports.iter().all(there) {
            let what = "a support is of a point that is not there";
            return Err(ExportError::Series { index: frame.index, what });
        }
        #[expect(clippy::cast_possible_truncation, reason = "it is more than is seen")]
        let line = |Strand { points, radii, .. }: Strand| Line {
            points: points.iter().map(|point| point.cast()).collect(),
            radii: radii.iter().map(|&radius| radius as f32).collect(),
        };
        let lines = frame.strands.into_iter().map(line).collect();
        Ok(Self { time: frame.time, lines, supports })
    }
}
