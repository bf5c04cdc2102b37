use super::chords::chords;
use crate::FiberError;
use nalgebra::Point3;

/// Part of its length by which a curve may differ from a fibre that is laid along it.
const SLACK: f64 = 0.01;

/// An open curve, straight from point to point, along which a fibre is laid.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenCurve {
    /// Its points, m, two or more.
    pub points: Vec<Point3<f64>>,
}

impl OpenCurve {
    /// Length of the curve, m.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.points.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum()
    }

    /// Nodes along the curve for segments of the given lengths, m, from its first point on; where
    /// the curve ends before the fibre it goes on straight.
    ///
    /// # Errors
    /// Refuses fewer than two points, points that are not finite or that coincide, a curve whose
    /// length differs from that of the fibre by more than a hundredth, and one that segments
    /// cannot follow.
    pub fn nodes(&self, lengths: &[f64]) -> Result<Vec<Point3<f64>>, FiberError> {
        let (points, count) = (&self.points, self.points.len());
        if count < 2 {
            let (quantity, range) = ("number of points of the curve", "[2, infinity)");
            return Err(FiberError::OutOfRange { quantity, value: count as f64, range });
        }
        if let Some(index) = points.iter().position(|p| !p.coords.iter().all(|x| x.is_finite())) {
            return Err(FiberError::NotFinite { quantity: "point of the curve", index });
        }
        if let Some(index) = points.windows(2).position(|ends| ends[0] == ends[1]) {
            return Err(FiberError::Coincident { index });
        }
        let (found, wanted) = (self.length(), lengths.iter().sum::<f64>());
        if (found / wanted - 1.0).abs() > SLACK {
            return Err(FiberError::CurveLength { found, wanted });
        }
        let mut ways = vec![0.0];
        for ends in points.windows(2) {
            ways.push(ways[ways.len() - 1] + (ends[1] - ends[0]).norm());
        }
        let at = |way: f64| {
            let i = ways.partition_point(|w| *w <= way).clamp(1, count - 1);
            let part = (way - ways[i - 1]) / (ways[i] - ways[i - 1]);
            points[i - 1] + part * (points[i] - points[i - 1])
        };
        let nodes = chords(lengths, at);
        let follows = |(ends, length): (&[Point3<f64>], &f64)| {
            ((ends[1] - ends[0]).norm() - length).abs() < 1e-9 * length
        };
        if nodes.windows(2).zip(lengths).all(follows) {
            return Ok(nodes);
        }
        let segments = lengths.len();
        Err(FiberError::Unresolved { segments, needed: 2.0 * segments as f64 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{Handedness, Wound};
    use std::f64::consts::{PI, TAU};

    #[test]
    fn nodes_lie_on_the_curve_at_their_lengths() {
        let bend = |k: u32| {
            let angle = PI * f64::from(k) / 400.0;
            Point3::new(angle.cos(), angle.sin(), 0.0)
        };
        let curve = OpenCurve { points: (0..=400).map(bend).collect() };
        let lengths = [PI / 20.0; 20];
        let nodes = curve.nodes(&lengths).expect("a fit");
        for (ends, length) in nodes.windows(2).zip(lengths) {
            assert!(((ends[1] - ends[0]).norm() - length).abs() < 1e-12);
            // A point of a chord is off the arc by the square of the points' distance.
            assert!((ends[0].coords.norm() - 1.0).abs() < (PI / 400.0_f64).powi(2));
        }
        let short = curve.nodes(&[PI / 21.0; 20]).expect_err("too short");
        assert!(short.to_string().contains("3.14"), "{short}");
    }

    /// The segments of a winding touch their cylinder in their middles, and its ends are straight.
    #[test]
    fn a_winding_clears_its_cylinder() {
        let wound = Wound {
            radius: 0.01,
            turns: 2.5,
            pitch: 0.002,
            handedness: Handedness::Left,
            lead: 0.03,
        };
        let lengths = [0.002; 120];
        let nodes = wound.nodes(&lengths).expect("a winding");
        let mut touching = 0;
        for (ends, length) in nodes.windows(2).zip(lengths) {
            assert!(((ends[1] - ends[0]).norm() - length).abs() < 1e-12);
            let along = (ends[1] - ends[0]).xy();
            let part = (-ends[0].coords.xy().dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            let least = (ends[0].coords.xy() + part * along).norm();
            assert!(least > 0.01 * (1.0 - 1e-9), "{least}");
            touching += u32::from(least < 0.01 * (1.0 + 1e-9));
        }
        let around = 2.5 * (TAU * 0.01_f64).hypot(0.002) / 0.002;
        assert!((f64::from(touching) - around).abs() < 2.0, "{touching} for {around}");
        let line = nodes[0] - nodes[10];
        assert!(line.cross(&(nodes[3] - nodes[10])).norm() < 1e-12 * line.norm());
        let long = Wound { turns: 4.0, ..wound };
        assert!(long.nodes(&lengths).is_err());
    }
}
