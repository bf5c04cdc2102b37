//! A triangle with its charge spread evenly, as seen from a point in each lane.

use crate::vectors::{LaneVector, along, dot, log, minus};
use nalgebra::{Point3, Vector3};
use pulp::{Scalar, Simd};
use rapunzel_lanes::{Lane, Portable, Roots, angle};

/// Triangle with its charge spread evenly.
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    /// Corners (world), m.
    corners: [Point3<f64>; 3],
    /// Unit normal (world), by the order of the corners.
    normal: Vector3<f64>,
    /// Unit vectors (world) along each side and outward from it, in the plane.
    sides: [[Vector3<f64>; 2]; 3],
    /// Area, m^2.
    area: f64,
    /// Center (world), m.
    center: Point3<f64>,
    /// Longest side, m.
    longest: f64,
    /// Points (world, m) of [`RULE`], and their shares of the triangle.
    points: [(Point3<f64>, f64); POINTS],
}

/// Distance from the center, over the longest side, from where on [`RULE`] stands for the triangle:
/// with errors below those of its center beyond three.
pub(super) const RULED: f64 = 1.2;

/// Number of points of [`RULE`].
pub(super) const POINTS: usize = 7;

/// Radon's rule of fifth degree: barycentric coordinates of points, the first once and the others
/// with all corners in turn, and weights.
const RULE: [([f64; 2], f64); 3] = [
    ([1.0 / 3.0, 1.0 / 3.0], 0.225),
    ([0.059_715_871_789_769_82, 0.470_142_064_105_115_1], 0.132_394_152_788_506_2),
    ([0.797_426_985_353_087_3, 0.101_286_507_323_456_34], 0.125_939_180_544_827_15),
];

/// Means over a triangle of `1/r` from the points in all lanes, 1/m, and the gradients by these
/// points, 1/m^2.
pub(super) type TriangleMeans<S> = [Lane<S>; 4];

impl Triangle {
    /// Triangle with these corners (world, m), which do not lie on a line.
    pub(super) fn new(corners: [Point3<f64>; 3]) -> Self {
        let [a, b, c] = corners;
        let normal = (b - a).cross(&(c - a));
        let double = normal.norm();
        let normal = normal / double;
        let side = |k: usize| {
            let along = (corners[(k + 1) % 3] - corners[k]).normalize();
            [along, along.cross(&normal)]
        };
        let center = ((a.coords + b.coords + c.coords) / 3.0).into();
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let mut points = [(center, RULE[0].1); POINTS];
        for (k, point) in points[1..].iter_mut().enumerate() {
            let ([first, second], weight) = RULE[1 + k / 3];
            let [a, b, c] = [0, 1, 2].map(|i| corners[(i + k) % 3].coords);
            let place = a * first + b * second + c * (1.0 - first - second);
            *point = (place.into(), weight);
        }
        let (sides, area) = ([0, 1, 2].map(side), 0.5 * double);
        Self { corners, normal, sides, area, center, longest, points }
    }

    /// Corners (world), m.
    pub(super) fn corners(&self) -> [Point3<f64>; 3] {
        self.corners
    }

    /// Center (world), m.
    pub(super) fn center(&self) -> Point3<f64> {
        self.center
    }

    /// Longest side, m.
    pub(super) fn longest(&self) -> f64 {
        self.longest
    }

    /// Points (world, m) that stand for the triangle where it is not close, and their shares of it.
    pub(super) fn points(&self) -> [(Point3<f64>, f64); POINTS] {
        self.points
    }

    /// Mean of `1/r` over the triangle as seen from the point `x` (world, m), 1/m.
    pub(super) fn mean(&self, x: &Point3<f64>) -> f64 {
        let x = lanes(Scalar::new(), &x.coords);
        self.means(Portable, &x)[0].reduce_sum()
    }

    /// Means at the points `x` (world, m): by [`points`](Self::points) where the triangle is not
    /// close to them, else exact.
    #[inline(always)]
    pub(super) fn means<S: Simd, R: Roots<S>>(
        &self,
        roots: R,
        x: &LaneVector<S>,
    ) -> TriangleMeans<S> {
        let r = minus(x, &lanes(x[0].simd(), &self.center.coords));
        let (r2, close) = (dot(&r, &r), x[0].lift((RULED * self.longest).powi(2)));
        if !r2.less_than(close).any() {
            return self.by_points(roots, x);
        }
        let mut means = self.exact(roots, x);
        if close.less_than(r2).any() {
            for (mean, ruled) in means.iter_mut().zip(self.by_points(roots, x)) {
                *mean = r2.less_than(close).select(*mean, ruled);
            }
        }
        means
    }

    /// Means at `x` (world, m) by [`points`](Self::points), which do not act on their own places.
    #[inline(always)]
    fn by_points<S: Simd, R: Roots<S>>(&self, roots: R, x: &LaneVector<S>) -> TriangleMeans<S> {
        let mut means = [x[0].lift(0.0); 4];
        for (point, weight) in &self.points {
            let r = minus(x, &lanes(x[0].simd(), &point.coords));
            let inverse = roots.rsqrt(dot(&r, &r));
            let potential = x[0].lift(*weight) * inverse;
            means[0] = means[0] + potential;
            let slope = potential * inverse * inverse;
            for c in 0..3 {
                means[1 + c] = slope.negate_mul_add(r[c], means[1 + c]);
            }
        }
        means
    }

    /// Means at `x` (world, m), exact everywhere (Wilton and others, 1984): a logarithm for each
    /// side and the solid angle (van Oosterom and Strackee, 1983). In the plane, where the gradient
    /// jumps across the triangle, it is the mean of both sides.
    #[inline(always)]
    fn exact<S: Simd, R: Roots<S>>(&self, roots: R, x: &LaneVector<S>) -> TriangleMeans<S> {
        let (simd, zero) = (x[0].simd(), x[0].lift(0.0));
        let mut to = [[zero; 3]; 3];
        let mut lengths = [zero; 3];
        for k in 0..3 {
            to[k] = minus(&lanes(simd, &self.corners[k].coords), x);
            lengths[k] = dot(&to[k], &to[k]).sqrt();
        }
        let normal = lanes(simd, &self.normal);
        let height = -dot(&to[0], &normal);
        let [a, b, c] = &to;
        let [ra, rb, rc] = lengths;
        // Solid angle: twice the angle whose tangent is the triple product over this sum (van
        // Oosterom and Strackee).
        let spread = dot(a, c).mul_add(rb, dot(b, c).mul_add(ra, ra * rb * rc));
        let spread = dot(a, b).mul_add(rc, spread);
        let half = angle(roots, spread, height.abs() * zero.lift(2.0 * self.area));
        let solid_angle = half + half;
        let sign = height.less_than(zero).select(zero.lift(-1.0), zero.lift(1.0));
        let sign = zero.less_than(height.abs()).select(sign, zero);
        let mut potential = -(height.abs() * solid_angle);
        let mut gradient = along(&[zero; 3], &normal, -(sign * solid_angle));
        for k in 0..3 {
            // A logarithm for each side (Wilton and others).
            let [tangent, outward] = &self.sides[k];
            let (tangent, outward) = (lanes(simd, tangent), lanes(simd, outward));
            let (next, p) = ((k + 1) % 3, dot(&to[k], &outward));
            let ways = [dot(&to[k], &tangent), dot(&to[next], &tangent)];
            // On the side itself nothing is left of its part of the potential.
            let gap2 = p.mul_add(p, height * height);
            let log = log(roots, ways, [lengths[k], lengths[next]]);
            let log = zero.lift(1e-28 * self.area).less_than(gap2).select(log, zero);
            potential = p.mul_add(log, potential);
            gradient = along(&gradient, &outward, -log);
        }
        let over = zero.lift(1.0 / self.area);
        let [x, y, z] = gradient;
        [potential * over, x * over, y * over, z * over]
    }
}

/// Vector `v` in all lanes.
#[inline(always)]
fn lanes<S: Simd>(simd: S, v: &Vector3<f64>) -> LaneVector<S> {
    [Lane::splat(simd, v.x), Lane::splat(simd, v.y), Lane::splat(simd, v.z)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(means: TriangleMeans<Scalar>) -> (f64, Vector3<f64>) {
        let [potential, x, y, z] = means.map(|mean| mean.reduce_sum());
        (potential, Vector3::new(x, y, z))
    }

    fn by_points(triangle: &Triangle, x: &Point3<f64>) -> (f64, Vector3<f64>) {
        numbers(triangle.by_points(Portable, &lanes(Scalar::new(), &x.coords)))
    }

    fn exact(triangle: &Triangle, x: &Point3<f64>) -> (f64, Vector3<f64>) {
        numbers(triangle.exact(Portable, &lanes(Scalar::new(), &x.coords)))
    }

    /// The rule is right to what three sides away is lost by the center: the second moments of the
    /// triangle, at most a twelfth of its longest side squared, over the squared distance.
    #[test]
    fn the_rule_is_as_good_as_a_point_beyond() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.1, 0.2], [0.3, 0.8, -0.1]].map(Point3::from);
        let triangle = Triangle::new(corners);
        for direction in [[1.0, 0.0, 0.0], [0.2, -0.5, 0.7], [-0.3, 0.9, 0.1], [0.0, 0.1, 1.0]] {
            let away = RULED * 1.001 * triangle.longest() * Vector3::from(direction).normalize();
            let x = triangle.center() + away;
            let (potential, gradient) = by_points(&triangle, &x);
            let (mean, slope) = exact(&triangle, &x);
            assert!((potential / mean - 1.0).abs() < 1.0 / 12.0 / 9.0, "{potential}, not {mean}");
            assert!((gradient - slope).norm() < 3.0 / 12.0 / 9.0 * slope.norm(), "{gradient}");
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_potential() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.1, 0.2], [0.3, 0.8, -0.1]].map(Point3::from);
        let triangle = Triangle::new(corners);
        for at in [[0.3, 0.2, 0.3], [0.4, 0.3, -0.1], [2.0, 0.1, 0.4], [-0.2, 0.5, 0.01]] {
            let at = Point3::from(at);
            let (_, gradient) = exact(&triangle, &at);
            for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
                let potential = |t: f64| exact(&triangle, &(at + t * axis)).0;
                let slope = (potential(1e-5) - potential(-1e-5)) / 2e-5;
                assert!((slope - gradient.dot(&axis)).abs() < 1e-8, "{slope} at {at}");
            }
        }
    }
}
