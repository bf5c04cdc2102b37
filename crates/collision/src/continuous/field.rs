//! A moving segment and a surface at rest.

use super::advance::{MovingPart, PartSample, first_impact};
use super::{Impact, MovingSegment, Path};
use crate::field::DistanceField;
use nalgebra::{Point3, Vector3};

impl MovingSegment {
    /// When the segment first comes within `reach`, m, of the surface of a field, less than its
    /// band; the coordinate is the fraction along it, and the offset leads to the surface.
    ///
    /// Nothing is missed of the zero set of the field, and the tolerance is that of
    /// [`impact`](Self::impact), in values of the field. Nothing is known of the field but its
    /// slope, so the surface must be sampled about as finely as the gap: a segment that comes to
    /// lie flat, or slides at a small height, may be given up, which is an alarm that is not
    /// resolved, at a gap of less than about a thousandth of its length and of its way. A finer
    /// tolerance is of no use. Cost: two or three samples for a segment that is far away, 8192 at
    /// most.
    #[must_use]
    pub fn impact_on(
        &self,
        field: &impl DistanceField,
        reach: f64,
        tolerance: f64,
    ) -> Option<Impact<1>> {
        let origin = self.before[0];
        let ends = [0, 1].map(|k| Path::new(origin, self.before[k], self.after[k]));
        let scale = origin.coords.lp_norm(1) + ends.iter().map(Path::scale).sum::<f64>();
        first_impact(
            SegmentPiece { field, origin, ends, range: [0.0, 1.0] },
            scale,
            reach,
            tolerance,
        )
    }
}

/// A piece of the segment.
struct SegmentPiece<'a, F> {
    field: &'a F,
    origin: Point3<f64>,
    ends: [Path; 2],
    range: [f64; 2],
}

impl<F> Clone for SegmentPiece<'_, F> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<F> Copy for SegmentPiece<'_, F> {}

impl<F: DistanceField> MovingPart<1> for SegmentPiece<'_, F> {
    /// What is known of the values along the piece, or that a ball around its middle is clear of
    /// the surface, says how far its ends may go until any of it can be there.
    fn look(&self, time: f64, keep: f64) -> PartSample<1> {
        let [a, b] = self.ends;
        let middle = a.middle(&b);
        let sample = self.field.sample(&(self.origin + middle.at(time)));
        let clear = (sample.value - keep) / self.field.lipschitz();
        let [start, end] = [a, b].map(|end| self.origin + end.at(time));
        let least = (self.field.least_between(&start, &end) - keep) / self.field.lipschitz();
        let room = least.max(clear - 0.5 * (end - start).norm());
        let speed = a.velocity.norm().max(b.velocity.norm());
        let until = |room: f64, speed: f64| if room > 0.0 { time + room / speed } else { time };
        PartSample {
            coordinates: [0.5 * (self.range[0] + self.range[1])],
            offset: -sample.value
                * sample.gradient.try_normalize(0.0).unwrap_or_else(Vector3::zeros),
            distance: sample.value,
            safe: until(room, speed),
            hope: until(clear, middle.velocity.norm()),
        }
    }

    fn halves(&self, look: &PartSample<1>) -> [Self; 2] {
        let ([a, b], [low, high], [s]) = (self.ends, self.range, look.coordinates);
        let middle = a.middle(&b);
        [
            Self { ends: [a, middle], range: [low, s], ..*self },
            Self { ends: [middle, b], range: [s, high], ..*self },
        ]
    }
}
