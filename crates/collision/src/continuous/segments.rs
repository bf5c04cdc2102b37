//! Two moving segments: their difference is a parallelogram that moves past the origin.

use super::advance::{MovingPart, PartSample, first_impact, separated};
use super::{Impact, Path};
use crate::Capsule;
use nalgebra::Point3;

/// A straight segment whose ends move with constant velocities over a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingSegment {
    /// Both ends when the step begins (world), m.
    pub before: [Point3<f64>; 2],
    /// Both ends when it is over (world), m.
    pub after: [Point3<f64>; 2],
}

impl MovingSegment {
    /// The axis of a capsule that is at `before` and then at `after`.
    #[must_use]
    pub fn between(before: &Capsule, after: &Capsule) -> Self {
        Self { before: [before.start, before.end], after: [after.start, after.end] }
    }

    /// The segment at a time of the step, in 0..=1, as the axis of a capsule.
    #[must_use]
    pub fn at(&self, time: f64, radius: f64) -> Capsule {
        let end = |k: usize| self.before[k] + time * (self.after[k] - self.before[k]);
        Capsule { start: end(0), end: end(1), radius }
    }

    /// When this segment and another first come within `reach`, m, at least 0; the coordinates are
    /// the fractions along the first and the second.
    ///
    /// `tolerance`, m, is the width of the band of false alarms; it is at least the rounding of the
    /// coordinates, about 1e-14 of the distances that occur. A part of a thousand of the reach, or
    /// a millionth of the length for a reach of zero, is a good choice. Segments of any kind may be
    /// given: points, parallel, coplanar, at rest. If coordinates are not finite the answer is an
    /// impact at time 0. Cost: one or two closest points for segments that pass at a distance,
    /// about eight where they touch, 8192 at most.
    #[must_use]
    pub fn impact(&self, other: &Self, reach: f64, tolerance: f64) -> Option<Impact<2>> {
        let path = |of: &Self, k: usize| Path::new(self.before[0], of.before[k], of.after[k]);
        let [a, b] = [[path(self, 0), path(self, 1)], [path(other, 0), path(other, 1)]];
        let scale = [a, b].as_flattened().iter().map(Path::scale).sum();
        let corners = [b[0].minus(&a[0]), b[0].minus(&a[1]), b[1].minus(&a[0]), b[1].minus(&a[1])];
        let whole = Difference { corners, ranges: [[0.0, 1.0]; 2] };
        first_impact(whole, scale, reach, tolerance)
    }
}

/// The points of a part of the second segment minus those of a part of the first.
#[derive(Clone, Copy)]
struct Difference {
    /// At the low and the high end of the first part, and then the same for the second.
    corners: [Path; 4],
    /// Which fractions of the first and of the second segment.
    ranges: [[f64; 2]; 2],
}

impl MovingPart<2> for Difference {
    fn look(&self, time: f64, keep: f64) -> PartSample<2> {
        let at = |k: usize| self.corners[k].at(time);
        let axis = |start, end| Capsule { start, end, radius: 0.0 };
        let first = axis(Point3::origin(), Point3::from(at(0) - at(1)));
        let second = axis(Point3::from(at(0)), Point3::from(at(2)));
        let closest = first.closest(&second);
        let [s, u] = closest.fractions;
        let [v0, v1, v2, _] = self.corners.map(|corner| corner.velocity);
        let velocity = v0 + s * (v1 - v0) + u * (v2 - v0);
        let distance = closest.distance();
        let normal = closest.offset / distance;
        let along = |[low, high]: [f64; 2], t: f64| low + t * (high - low);
        PartSample {
            coordinates: [along(self.ranges[0], s), along(self.ranges[1], u)],
            offset: closest.offset,
            distance,
            safe: separated(&self.corners, &normal, time, keep),
            hope: time + (distance - keep) / (-normal.dot(&velocity)).max(0.0),
        }
    }

    /// Cuts the segment along which the velocity toward the origin changes most.
    fn halves(&self, look: &PartSample<2>) -> [Self; 2] {
        let [c0, c1, c2, c3] = self.corners;
        let change = |c: Path| (c.velocity - c0.velocity).dot(&look.offset).abs();
        let [[s0, s1], [u0, u1]] = self.ranges;
        if change(c1) >= change(c2) {
            let (low, high, s) = (c0.middle(&c1), c2.middle(&c3), 0.5 * (s0 + s1));
            [
                Self { corners: [c0, low, c2, high], ranges: [[s0, s], [u0, u1]] },
                Self { corners: [low, c1, high, c3], ranges: [[s, s1], [u0, u1]] },
            ]
        } else {
            let (low, high, u) = (c0.middle(&c2), c1.middle(&c3), 0.5 * (u0 + u1));
            [
                Self { corners: [c0, c1, low, high], ranges: [[s0, s1], [u0, u]] },
                Self { corners: [low, high, c2, c3], ranges: [[s0, s1], [u, u1]] },
            ]
        }
    }
}
