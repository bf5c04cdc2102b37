//! A moving point and a moving triangle.

use super::advance::{MovingPart, PartSample, first_impact, separated};
use super::{Impact, Path};
use crate::triangle::nearest_weights;
use nalgebra::{Matrix3, Point3, Vector3};

/// A point in uniform motion over a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingPoint {
    /// Where it is when the step begins (world), m.
    pub before: Point3<f64>,
    /// Where it is when the step is over (world), m.
    pub after: Point3<f64>,
}

/// A triangle whose corners move with constant velocities over a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingTriangle {
    /// The corners when the step begins (world), m.
    pub before: [Point3<f64>; 3],
    /// The corners when it is over (world), m.
    pub after: [Point3<f64>; 3],
}

impl MovingPoint {
    /// When the point and a triangle first come within `reach`, m; the coordinates are the weights
    /// of the corners. All else is as for [`MovingSegment::impact`](super::MovingSegment::impact).
    #[must_use]
    pub fn impact(
        &self,
        triangle: &MovingTriangle,
        reach: f64,
        tolerance: f64,
    ) -> Option<Impact<3>> {
        let point = Path::new(self.before, self.before, self.after);
        let corner = |k: usize| Path::new(self.before, triangle.before[k], triangle.after[k]);
        let corners = [0, 1, 2].map(corner);
        let scale = point.scale() + corners.iter().map(Path::scale).sum::<f64>();
        let corners = corners.map(|corner| corner.minus(&point));
        first_impact(Face { corners, weights: Matrix3::identity() }, scale, reach, tolerance)
    }
}

/// A part of the triangle, seen from the point.
#[derive(Clone, Copy)]
struct Face {
    corners: [Path; 3],
    /// In each column the weights of one corner of the part.
    weights: Matrix3<f64>,
}

impl MovingPart<3> for Face {
    fn look(&self, time: f64, keep: f64) -> PartSample<3> {
        let at = |k: usize| self.corners[k].at(time);
        let weights = nearest_weights(&[at(0), at(1), at(2)]);
        let sum = |value: &dyn Fn(usize) -> Vector3<f64>| -> Vector3<f64> {
            (0..3).map(|k| weights[k] * value(k)).sum()
        };
        let offset = sum(&at);
        let velocity = sum(&|k| self.corners[k].velocity);
        let distance = offset.norm();
        let normal = offset / distance;
        PartSample {
            coordinates: (self.weights * Vector3::from(weights)).into(),
            offset,
            distance,
            safe: separated(&self.corners, &normal, time, keep),
            hope: time + (distance - keep) / (-normal.dot(&velocity)).max(0.0),
        }
    }

    /// Cuts the side along which the velocity toward the point changes most.
    fn halves(&self, look: &PartSample<3>) -> [Self; 2] {
        let rate = |k: usize| self.corners[k].velocity.dot(&look.offset);
        let change = |k: &usize| (rate(*k) - rate((k + 1) % 3)).abs();
        let i = (0..3).max_by(|a, b| change(a).total_cmp(&change(b))).unwrap_or(0);
        let j = (i + 1) % 3;
        let middle = self.corners[i].middle(&self.corners[j]);
        let weights = 0.5 * (self.weights.column(i) + self.weights.column(j));
        [i, j].map(|k| {
            let mut half = *self;
            half.corners[k] = middle;
            half.weights.set_column(k, &weights);
            half
        })
    }
}
