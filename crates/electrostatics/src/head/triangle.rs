//! A triangle with its charge spread evenly.

use nalgebra::{Point3, Vector3};

/// A triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    corners: [Point3<f64>; 3],
    normal: Vector3<f64>,
    area: f64,
    center: Point3<f64>,
    longest: f64,
    /// The points of [`RULE`], and their shares of the triangle.
    points: [(Point3<f64>, f64); POINTS],
}

/// Distance from the center, over the longest side, from where on [`RULE`] stands for the triangle: with
/// errors below those of its center beyond three.
pub(super) const RULED: f64 = 1.2;

/// Points of [`RULE`].
pub(super) const POINTS: usize = 7;

/// Radon's rule of fifth degree: barycentric coordinates of points, the first once and the others with
/// all corners in turn, and weights.
const RULE: [([f64; 2], f64); 3] = [
    ([1.0 / 3.0, 1.0 / 3.0], 0.225),
    ([0.059_715_871_789_769_82, 0.470_142_064_105_115_1], 0.132_394_152_788_506_2),
    ([0.797_426_985_353_087_3, 0.101_286_507_323_456_34], 0.125_939_180_544_827_15),
];

impl Triangle {
    pub(super) fn new(corners: [Point3<f64>; 3]) -> Self {
        let [a, b, c] = corners;
        let normal = (b - a).cross(&(c - a));
        let double = normal.norm();
        let center = ((a.coords + b.coords + c.coords) / 3.0).into();
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let mut points = [(center, RULE[0].1); POINTS];
        for (k, point) in points[1..].iter_mut().enumerate() {
            let ([first, second], weight) = RULE[1 + k / 3];
            let [a, b, c] = [0, 1, 2].map(|i| corners[(i + k) % 3].coords);
            let place = a * first + b * second + c * (1.0 - first - second);
            *point = (place.into(), weight);
        }
        Self { corners, normal: normal / double, area: 0.5 * double, center, longest, points }
    }

    pub(super) fn center(&self) -> Point3<f64> {
        self.center
    }

    pub(super) fn longest(&self) -> f64 {
        self.longest
    }

    /// Whether [`points`](Self::points) do not stand for the triangle as seen from `x`.
    pub(super) fn is_close(&self, x: &Point3<f64>) -> bool {
        (x - self.center).norm() < RULED * self.longest
    }

    /// The points that stand for it where it is not close, and their shares of it.
    pub(super) fn points(&self) -> [(Point3<f64>, f64); POINTS] {
        self.points
    }

    /// The mean of `1/r` over [`points`](Self::points) as seen from `x`, and its gradient; a point does not
    /// act on its own place.
    pub(super) fn by_points(&self, x: &Point3<f64>) -> (f64, Vector3<f64>) {
        let (mut potential, mut gradient) = (0.0, Vector3::zeros());
        for (point, weight) in &self.points {
            let r = x - point;
            let length = r.norm();
            if length > 0.0 {
                let share = weight / length;
                potential += share;
                gradient -= share / (length * length) * r;
            }
        }
        (potential, gradient)
    }

    /// The mean of `1/r` over the triangle as seen from `x`, and its gradient by x, everywhere exact
    /// (Wilton and others, 1984): a logarithm for each side and the solid angle (van Oosterom and
    /// Strackee, 1983). In the plane, where the gradient jumps across the triangle, it is the mean of
    /// both sides.
    pub(super) fn exact(&self, x: &Point3<f64>) -> (f64, Vector3<f64>) {
        let height = (x - self.corners[0]).dot(&self.normal);
        let sign = if height == 0.0 { 0.0 } else { height.signum() };
        let to = self.corners.map(|corner| corner - x);
        let lengths = to.map(|to| to.norm());
        let angle = self.solid_angle(height.abs(), &to, lengths);
        let (mut potential, mut gradient) = (-height.abs() * angle, -sign * angle * self.normal);
        for k in 0..3 {
            let next = (k + 1) % 3;
            let along = (to[next] - to[k]).normalize();
            let outward = along.cross(&self.normal);
            let p = to[k].dot(&outward);
            // On the side itself nothing is left of its part of the potential.
            if p * p + height * height <= 1e-28 * self.area {
                continue;
            }
            let [la, lb] = [to[k].dot(&along), to[next].dot(&along)];
            let [ra, rb] = [lengths[k], lengths[next]];
            // The form that does not cancel.
            let ratio = if la + lb > 0.0 { (rb + lb) / (ra + la) } else { (ra - la) / (rb - lb) };
            let log = ratio.ln();
            potential += p * log;
            gradient -= log * outward;
        }
        (potential / self.area, gradient / self.area)
    }

    /// The solid angle that the triangle fills, seen from a `height` over its plane, with vectors to
    /// its corners and their lengths.
    fn solid_angle(&self, height: f64, to: &[Vector3<f64>; 3], lengths: [f64; 3]) -> f64 {
        let [a, b, c] = to;
        let [ra, rb, rc] = lengths;
        let denominator = ra * rb * rc + a.dot(b) * rc + a.dot(c) * rb + b.dot(c) * ra;
        2.0 * (2.0 * self.area * height).atan2(denominator)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rule is right to what three sides away is lost by the center: the second moments of the
    /// triangle, at most a twelfth of its longest side squared, over the squared distance.
    #[test]
    fn the_rule_is_as_good_as_a_point_beyond() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.1, 0.2], [0.3, 0.8, -0.1]].map(Point3::from);
        let triangle = Triangle::new(corners);
        for direction in [[1.0, 0.0, 0.0], [0.2, -0.5, 0.7], [-0.3, 0.9, 0.1], [0.0, 0.1, 1.0]] {
            let away = RULED * 1.001 * triangle.longest() * Vector3::from(direction).normalize();
            let x = triangle.center() + away;
            let (potential, gradient) = triangle.by_points(&x);
            let (exact, slope) = triangle.exact(&x);
            assert!((potential / exact - 1.0).abs() < 1.0 / 12.0 / 9.0, "{potential}, not {exact}");
            assert!((gradient - slope).norm() < 3.0 / 12.0 / 9.0 * slope.norm(), "{gradient}");
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_potential() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.1, 0.2], [0.3, 0.8, -0.1]].map(Point3::from);
        let triangle = Triangle::new(corners);
        for at in [[0.3, 0.2, 0.3], [0.4, 0.3, -0.1], [2.0, 0.1, 0.4], [-0.2, 0.5, 0.01]] {
            let at = Point3::from(at);
            let (_, gradient) = triangle.exact(&at);
            for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
                let potential = |t: f64| triangle.exact(&(at + t * axis)).0;
                let slope = (potential(1e-5) - potential(-1e-5)) / 2e-5;
                assert!((slope - gradient.dot(&axis)).abs() < 1e-8, "{slope} at {at}");
            }
        }
    }
}
