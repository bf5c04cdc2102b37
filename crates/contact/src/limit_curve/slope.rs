//! How the nearest point of a limit curve moves.

use super::{LimitCurve, quarter};
use nalgebra::{Matrix2, Vector2};

/// The nearest point of a limit curve's inside, and how it moves with what it is nearest to.
pub(crate) struct NearestFriction {
    /// The point itself, N s.
    pub(crate) point: Vector2<f64>,
    /// Derivative by what it is nearest to; one of several where curve or point has a corner.
    pub(crate) slope: Matrix2<f64>,
    /// Derivative by the scale of the curve.
    pub(crate) growth: Vector2<f64>,
}

impl LimitCurve {
    /// The point of [`Self::project`] with its derivatives.
    pub(crate) fn nearest(&self, p: &Vector2<f64>, scale: f64) -> NearestFriction {
        let point = self.project(p, scale);
        let apart = p - point;
        let slope = if apart == Vector2::zeros() {
            Matrix2::identity()
        } else if scale > 0.0 {
            self.slope(&point, &apart, scale)
        } else {
            Matrix2::zeros()
        };
        // Twice as far from a curve twice as large the nearest point is twice as far (Euler).
        let growth = if scale > 0.0 { (point - slope * p) / scale } else { Vector2::zeros() };
        NearestFriction { point, slope, growth }
    }

    /// Derivative of the nearest point by what is `apart` from it: along the curve, the less the
    /// more the curve bends there.
    fn slope(&self, point: &Vector2<f64>, apart: &Vector2<f64>, scale: f64) -> Matrix2<f64> {
        let distance = apart.norm();
        let along = Vector2::new(-apart.y, apart.x) / distance;
        let Some(mu) = self.semi_axes() else {
            let Self::Polygon(polygon) = self else { return Matrix2::identity() };
            let is_corner = polygon.vertices().iter().any(|vertex| vertex * scale == *point);
            return if is_corner { Matrix2::zeros() } else { along * along.transpose() };
        };
        let [a, b] = quarter(&mu, point).map(|semi| semi * scale);
        if a <= 0.0 || b <= 0.0 {
            // A segment on an axis: what is beside it moves along, what is beyond its end does not.
            let free = |semi: f64, apart: f64| f64::from(semi > 0.0 && apart == 0.0);
            return Matrix2::new(free(a, apart.x), 0.0, 0.0, free(b, apart.y));
        }
        // Of (x/a)^2 + (y/b)^2 = 1 the curvature is t^T H t / |H z|, with H = diag(a^-2, b^-2).
        let squares = Vector2::new(1.0 / (a * a), 1.0 / (b * b));
        let bend = along.component_mul(&along).dot(&squares) / squares.component_mul(point).norm();
        along * along.transpose() / (1.0 + bend * distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Polygon;
    use proptest::prelude::*;

    fn curve() -> impl Strategy<Value = LimitCurve> {
        let mu = || 0.1..2.0;
        let hull = |points: Vec<(f64, f64)>| {
            let at = |(angle, size): (f64, f64)| Vector2::new(angle.cos(), angle.sin()) * size;
            let points: Vec<_> = points.into_iter().map(at).collect();
            Polygon::new(&points)
        };
        let polygon = prop::collection::vec((0.0..std::f64::consts::TAU, 0.5..2.0), 6..12)
            .prop_filter_map("around the origin", move |points| hull(points).ok());
        prop_oneof![
            mu().prop_map(|mu| LimitCurve::Circle { mu }),
            prop::array::uniform2(mu()).prop_map(|mu| LimitCurve::Ellipse { mu }),
            prop::array::uniform4(mu()).prop_map(|mu| LimitCurve::Quarters { mu }),
            polygon.prop_map(LimitCurve::Polygon),
        ]
    }

    proptest! {
        /// Differences of points that are nearest agree with the derivatives, but for the few that
        /// have a corner between them: there differences to both sides differ, too.
        #[test]
        fn derivatives_are_limits_of_differences(
            curve in curve(), p in prop::array::uniform2(-3.0..3.0), scale in 0.1..2.0
        ) {
            const STEP: f64 = 1e-6;
            let p = Vector2::from(p);
            let NearestFriction { slope, growth, .. } = curve.nearest(&p, scale);
            let at = |change: Vector2<f64>, more: f64| curve.project(&(p + change), scale + more);
            let pairs = [
                (slope.column(0).into_owned(), Vector2::x() * STEP, 0.0),
                (slope.column(1).into_owned(), Vector2::y() * STEP, 0.0),
                (growth, Vector2::zeros(), STEP),
            ];
            for (found, change, more) in pairs {
                let ahead = (at(change, more) - at(Vector2::zeros(), 0.0)) / STEP;
                let behind = (at(Vector2::zeros(), 0.0) - at(-change, -more)) / STEP;
                // Curvature is at most (2 / 0.1)^2 / 0.1 / scale; roundings are 1e-15 / STEP.
                prop_assume!((ahead - behind).norm() < 0.05);
                prop_assert!((found - 0.5 * (ahead + behind)).norm() < 0.05, "{found} {ahead}");
            }
        }
    }
}
