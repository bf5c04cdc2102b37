//! Closest points of two segments.

use crate::Capsule;
use nalgebra::{Point3, Vector3};

/// Where two segments come closest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest {
    /// Fractions along the first and the second axis, each in 0..=1.
    pub fractions: [f64; 2],
    /// From the point on the first axis to that on the second (world), m.
    pub offset: Vector3<f64>,
}

impl Closest {
    /// Distance of the two axes, m.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.offset.norm()
    }
}

impl Capsule {
    /// The point of the axis at `fraction` (world), m.
    #[must_use]
    pub fn at(&self, fraction: f64) -> Point3<f64> {
        self.start + fraction * (self.end - self.start)
    }

    /// Closest points of the two axes; one of them where there are many (parallel segments).
    ///
    /// The distance is the least to a few roundings of the coordinates, also for parallel,
    /// collinear and point-like segments: the squared distance is convex, so its least value on
    /// the square of fractions lies inside, where the lines come closest, or on one of the four
    /// sides; all five are tried. Cost: about 100 operations.
    #[must_use]
    pub fn closest(&self, other: &Self) -> Closest {
        let (d1, d2) = (self.end - self.start, other.end - other.start);
        let r = other.start - self.start;
        let (a, b, e) = (d1.norm_squared(), d1.dot(&d2), d2.norm_squared());
        let (c, f) = (d1.dot(&r), d2.dot(&r));
        let on_first = |t: f64| fraction(c + t * b, a);
        let on_second = |s: f64| fraction(s * b - f, e);
        let inside = fraction(c * e - b * f, a * e - b * b);
        let corners = [[0.0, on_second(0.0)], [1.0, on_second(1.0)], [on_first(0.0), 0.0]];
        // What is too large to be squared is infinitely far away.
        let mut best = Closest { fractions: [0.0; 2], offset: Vector3::repeat(f64::INFINITY) };
        let mut least = f64::INFINITY;
        let last = [on_first(1.0), 1.0];
        let t = on_second(inside);
        for [s, t] in [[on_first(t), t], corners[0], corners[1], corners[2], last] {
            let offset = r + t * d2 - s * d1;
            let squared = offset.norm_squared();
            if squared < least {
                least = squared;
                best = Closest { fractions: [s, t], offset };
            }
        }
        best
    }
}

/// `numerator / denominator` clamped to 0..=1; 0 where the denominator is not positive.
fn fraction(numerator: f64, denominator: f64) -> f64 {
    if denominator > 0.0 { (numerator / denominator).clamp(0.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Coordinates that often coincide, so that segments are parallel, collinear, or points.
    fn point() -> impl Strategy<Value = Point3<f64>> {
        let x = prop_oneof![(-2..=2_i8).prop_map(f64::from), -2.0..2.0_f64];
        prop::array::uniform3(x).prop_map(Point3::from)
    }

    fn segment() -> impl Strategy<Value = Capsule> {
        (point(), point(), 0.0..1e-6_f64, point()).prop_map(|(start, end, part, other)| {
            // A part of the segments is nearly parallel to the axes or nearly a point.
            Capsule { start, end: end + part * (other - end), radius: 1.0 }
        })
    }

    /// Distance of a point to a segment, by clamping.
    fn to_segment(p: Point3<f64>, q: &Capsule) -> f64 {
        let d = q.end - q.start;
        let t = if d.norm_squared() > 0.0 { d.dot(&(p - q.start)) / d.norm_squared() } else { 0.0 };
        (p - q.at(t.clamp(0.0, 1.0))).norm()
    }

    proptest! {
        /// The distance to a segment is convex along the other one: a search by thirds finds it.
        #[test]
        fn the_distance_is_the_least(a in segment(), b in segment()) {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..120 {
                let (s, t) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                if to_segment(a.at(s), &b) <= to_segment(a.at(t), &b) { high = t } else { low = s }
            }
            let expected = to_segment(a.at(0.5 * (low + high)), &b);
            let closest = a.closest(&b);
            // The search resolves distances down to the square root of the rounding, near zero.
            prop_assert!(closest.distance() <= expected + 1e-14);
            prop_assert!(closest.distance() >= expected - 1e-7);
        }

        #[test]
        fn the_offset_joins_the_points(a in segment(), b in segment()) {
            let closest = a.closest(&b);
            let [s, t] = closest.fractions;
            prop_assert!((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t));
            prop_assert!((b.at(t) - a.at(s) - closest.offset).norm() <= 1e-14);
            let back = b.closest(&a);
            prop_assert!((back.distance() - closest.distance()).abs() <= 1e-14);
        }
    }
}
