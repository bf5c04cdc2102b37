use crate::set::length;
use crate::{StrandSet, StrandsError};
use nalgebra::Point3;

/// Strands with points at equal arc lengths of those they were made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Resampled {
    /// The new strands, with the same ends.
    pub strands: StrandSet,
    /// Largest distance between a strand and its new one, m: a bound of the Hausdorff distance of
    /// both polylines that is exact but for loops between two points.
    pub error: f64,
    /// Index of the strand with that distance.
    pub worst: usize,
    /// Largest part of its length that a strand has lost: corners are cut, so the new segments are
    /// chords that are no longer than the arcs.
    pub shortening: f64,
}

impl StrandSet {
    /// Puts `segments + 1` points on every strand at equal arc lengths along the polyline; radii
    /// are interpolated linearly.
    ///
    /// Nothing is smoothed: a rod has its natural shape from the points, and what was between them
    /// nobody knows. Cost: linear in the old and new points.
    ///
    /// # Errors
    /// [`StrandsError::Option`] without segments; [`StrandsError::Fold`] where two new points in a
    /// row would be equal.
    pub fn resampled(&self, segments: usize) -> Result<Resampled, StrandsError> {
        self.resampled_by(|_| segments)
    }

    /// The same with a number of segments of each strand, by its index.
    ///
    /// # Errors
    /// Those of [`resampled`](Self::resampled).
    pub fn resampled_by(
        &self,
        segments: impl Fn(usize) -> usize,
    ) -> Result<Resampled, StrandsError> {
        let mut out = Resampled {
            strands: Self::new(self.radii().is_some()),
            error: 0.0,
            worst: 0,
            shortening: 0.0,
        };
        for strand in 0..self.len() {
            let (points, segments) = (self.strand(strand), segments(strand));
            if segments == 0 {
                let (what, must) = ("segments", "at least 1");
                return Err(StrandsError::Option { what, value: "0".into(), must });
            }
            let places = places(points, segments);
            let new: Vec<_> = places.iter().map(|place| place.of(points)).collect();
            if new.windows(2).any(|ends| ends[0] == ends[1]) {
                return Err(StrandsError::Fold { strand, segments });
            }
            let error = error(points, &places, &new);
            if error > out.error {
                (out.error, out.worst) = (error, strand);
            }
            out.shortening = out.shortening.max(1.0 - length(&new) / length(points));
            let radii = self.radii().map(|all| &all[self.range(strand)]);
            let radius = |place: &Place| radii.map(|radii| place.between(radii));
            out.strands.push(self.sources()[strand], new, places.iter().filter_map(radius));
        }
        Ok(out)
    }

    /// Resamples all strands to as few segments as keep every one within a tolerance, m. Numbers
    /// of segments up to 16 are all tried, then those that grow by an eighth.
    ///
    /// # Errors
    /// [`StrandsError::Option`] for a tolerance that is not positive, and without segments;
    /// [`StrandsError::Tolerance`] if `most` segments are not enough, and [`StrandsError::Fold`] as
    /// in [`resampled`](Self::resampled) with these.
    pub fn resampled_within(&self, tolerance: f64, most: usize) -> Result<Resampled, StrandsError> {
        if tolerance.is_nan() || tolerance <= 0.0 {
            let (what, must) = ("tolerance", "positive");
            return Err(StrandsError::Option { what, value: tolerance.to_string(), must });
        }
        let mut segments = 1;
        loop {
            match self.resampled(segments.min(most)) {
                Ok(out) if out.error <= tolerance => return Ok(out),
                Ok(Resampled { error, worst: strand, .. }) if segments >= most => {
                    return Err(StrandsError::Tolerance { most, strand, error, tolerance });
                }
                Err(StrandsError::Fold { .. }) if segments < most => {}
                Err(error) => return Err(error),
                Ok(_) => {}
            }
            segments += (segments / 8).max(1);
        }
    }
}

/// A place on a polyline: the fraction of the way from point `segment` to the next.
struct Place {
    segment: usize,
    fraction: f64,
}

impl Place {
    fn of(&self, points: &[Point3<f64>]) -> Point3<f64> {
        let [a, b] = [points[self.segment], points[self.segment + 1]];
        // Exact at both ends.
        if self.fraction < 1.0 { a + self.fraction * (b - a) } else { b }
    }

    fn between(&self, values: &[f64]) -> f64 {
        let [a, b] = [values[self.segment], values[self.segment + 1]];
        a + self.fraction * (b - a)
    }
}

/// The places at equal arc lengths.
fn places(points: &[Point3<f64>], segments: usize) -> Vec<Place> {
    let whole = length(points);
    let last = points.len() - 2;
    let step = |segment: usize| (points[segment + 1] - points[segment]).norm();
    // Arc length at the start of a segment of the polyline.
    let (mut segment, mut start) = (0, 0.0);
    (0..=segments)
        .map(|k| {
            if k == segments {
                return Place { segment: last, fraction: 1.0 };
            }
            let s = whole * k as f64 / segments as f64;
            while segment < last && start + step(segment) <= s {
                start += step(segment);
                segment += 1;
            }
            let fraction = ((s - start) / step(segment)).clamp(0.0, 1.0);
            Place { segment, fraction }
        })
        .collect()
}

/// Largest distance of the old points from the chords over them.
///
/// The distance from a chord is convex along a straight line, so between two old points it is
/// nowhere larger than at them. And every point of a chord has one of the arc above it, no farther
/// off than the arc's farthest: so it bounds the distance either way.
fn error(points: &[Point3<f64>], places: &[Place], new: &[Point3<f64>]) -> f64 {
    let mut largest = 0.0_f64;
    for (ends, chord) in places.windows(2).zip(new.windows(2)) {
        let between = ends[0].segment + 1..=ends[1].segment;
        for point in points.get(between).unwrap_or_default() {
            largest = largest.max(distance(point, chord[0], chord[1]));
        }
    }
    largest
}

/// Distance of a point from a straight line between two ends, m.
fn distance(point: &Point3<f64>, start: Point3<f64>, end: Point3<f64>) -> f64 {
    let side = end - start;
    let squared = side.norm_squared();
    let t =
        if squared > 0.0 { (side.dot(&(point - start)) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (point - (start + t * side)).norm()
}
