//! A triangle with its charge spread evenly.

use nalgebra::{Point3, Vector3};

/// A triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    pub(super) corners: [Point3<f64>; 3],
    pub(super) normal: Vector3<f64>,
    pub(super) area: f64,
}

impl Triangle {
    pub(super) fn new(corners: [Point3<f64>; 3]) -> Self {
        let [a, b, c] = corners;
        let normal = (b - a).cross(&(c - a));
        let double = normal.norm();
        Self { corners, normal: normal / double, area: 0.5 * double }
    }

    pub(super) fn center(&self) -> Point3<f64> {
        let [a, b, c] = self.corners.map(|corner| corner.coords);
        ((a + b + c) / 3.0).into()
    }

    pub(super) fn longest(&self) -> f64 {
        let [a, b, c] = self.corners;
        (b - a).norm().max((c - b).norm()).max((a - c).norm())
    }

    /// The mean of `1/r` over the triangle as seen from `x`, everywhere exact (Wilton and others,
    /// 1984): a logarithm and two angles for each side.
    pub(super) fn potential(&self, x: &Point3<f64>) -> f64 {
        let height = (x - self.corners[0]).dot(&self.normal).abs();
        let side = |k| {
            let Side { p, log, angle, .. } = self.side(k, x);
            p * log - height * angle
        };
        (side(0) + side(1) + side(2)) / self.area
    }

    /// The gradient of [`potential`](Self::potential) by x; in the plane, where it jumps across the
    /// triangle, the mean of both sides.
    pub(super) fn gradient(&self, x: &Point3<f64>) -> Vector3<f64> {
        let height = (x - self.corners[0]).dot(&self.normal);
        let sign = if height == 0.0 { 0.0 } else { height.signum() };
        let side = |k| {
            let Side { outward, log, angle, .. } = self.side(k, x);
            -log * outward - sign * angle * self.normal
        };
        (side(0) + side(1) + side(2)) / self.area
    }

    fn side(&self, k: usize, x: &Point3<f64>) -> Side {
        let height = (x - self.corners[0]).dot(&self.normal).abs();
        let [a, b] = [self.corners[k], self.corners[(k + 1) % 3]];
        let along = (b - a).normalize();
        let outward = along.cross(&self.normal);
        let p = (a - x).dot(&outward);
        let [la, lb] = [(a - x).dot(&along), (b - x).dot(&along)];
        let [ra, rb] = [(a - x).norm(), (b - x).norm()];
        let r2 = p * p + height * height;
        if r2 <= 1e-28 * self.area {
            return Side { outward, p, log: 0.0, angle: 0.0 };
        }
        // The form of the logarithm that does not cancel.
        let log =
            if la + lb > 0.0 { ((rb + lb) / (ra + la)).ln() } else { ((ra - la) / (rb - lb)).ln() };
        let angle = |l: f64, r: f64| (p * l).atan2(r2 + height * r);
        Side { outward, p, log, angle: angle(lb, rb) - angle(la, ra) }
    }
}

/// A side as seen from a point.
struct Side {
    /// Unit normal out of the triangle, in its plane.
    outward: Vector3<f64>,
    /// Distance of the side in that direction.
    p: f64,
    /// Integral of `1/r` along it.
    log: f64,
    /// The part of the solid angle that it bounds.
    angle: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_is_that_of_the_potential() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.1, 0.2], [0.3, 0.8, -0.1]].map(Point3::from);
        let triangle = Triangle::new(corners);
        for at in [[0.3, 0.2, 0.3], [0.4, 0.3, -0.1], [2.0, 0.1, 0.4], [-0.2, 0.5, 0.01]] {
            let at = Point3::from(at);
            let gradient = triangle.gradient(&at);
            for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
                let potential = |t: f64| triangle.potential(&(at + t * axis));
                let slope = (potential(1e-5) - potential(-1e-5)) / 2e-5;
                assert!((slope - gradient.dot(&axis)).abs() < 1e-8, "{slope} at {at}");
            }
        }
    }
}
