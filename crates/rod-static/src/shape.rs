use nalgebra::{Point3, UnitQuaternion};

/// Shape of a [`Chain`](crate::Chain): the frames of its nodes, and with them its center line.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    pub(crate) frames: Vec<UnitQuaternion<f64>>,
    pub(crate) positions: Vec<Point3<f64>>,
}

impl Shape {
    /// Frames `[d1 d2 d3]` of the nodes, the clamp first; the tangent is d3.
    #[must_use]
    pub fn frames(&self) -> &[UnitQuaternion<f64>] {
        &self.frames
    }

    /// Positions of the nodes, m, world frame, the clamp first.
    #[must_use]
    pub fn positions(&self) -> &[Point3<f64>] {
        &self.positions
    }

    /// Positions of these nodes by Richardson's extrapolation, to fourth order in the length of a
    /// segment, from this shape and the same rod's shape `finer` in twice as many segments. `None`
    /// if it has not twice as many.
    #[must_use]
    pub fn extrapolated(&self, finer: &Self) -> Option<Vec<Point3<f64>>> {
        (finer.positions.len() == 2 * self.positions.len() - 1).then(|| {
            let pairs = self.positions.iter().zip(finer.positions.iter().step_by(2));
            pairs.map(|(coarse, fine)| fine + (fine - coarse) / 3.0).collect()
        })
    }
}
