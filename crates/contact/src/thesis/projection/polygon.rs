use super::Form;
use crate::{ContactError, LimitCurve, limit_curve};
use nalgebra::Vector2;
use std::f64::consts::PI;

/// The thesis's limit curve (8.48): directions `d_b` in the tangent plane and coefficients `mu_b`,
/// the curve being the convex hull of the origin and of the points `mu_b d_b`.
///
/// A direction whose point is inside the hull of the others has no effect, so that the condition of
/// convexity after (8.48) need not be asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct PolygonalCone {
    /// Unit directions with their coefficients, by rising angle.
    spokes: Vec<(Vector2<f64>, f64)>,
    /// `a . p <= b` for every pair, for a unit normal force.
    hull: Vec<(Vector2<f64>, f64)>,
}

impl PolygonalCone {
    /// A curve from (angle from `t1` to `t2` in rad, coefficient of friction in that direction of
    /// the force).
    ///
    /// # Errors
    /// [`ContactError::Invalid`] for angles that are not finite, coefficients that are not finite
    /// and >= 0, and for directions that leave half a turn or more without any.
    pub fn new(spokes: &[(f64, f64)]) -> Result<Self, ContactError> {
        for &(angle, mu) in spokes {
            if !(mu >= 0.0 && mu.is_finite()) {
                let why = "must be finite and >= 0";
                return Err(ContactError::Invalid {
                    what: "coefficient of friction",
                    value: mu,
                    why,
                });
            }
            if !angle.is_finite() {
                let why = "must be finite, in rad";
                return Err(ContactError::Invalid {
                    what: "angle of a direction of friction",
                    value: angle,
                    why,
                });
            }
        }
        let mut sorted: Vec<(f64, f64)> =
            spokes.iter().map(|&(angle, mu)| (angle.rem_euclid(2.0 * PI), mu)).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let wrap = sorted.first().map_or(0.0, |first| first.0 + 2.0 * PI);
        let next = sorted.iter().skip(1).map(|spoke| spoke.0).chain([wrap]);
        let gap = sorted.iter().zip(next).map(|(spoke, next)| next - spoke.0).fold(0.0, f64::max);
        if sorted.len() < 3 || gap >= PI * (1.0 - 1e-9) {
            return Err(ContactError::Invalid {
                what: "widest angle without a direction of friction, rad",
                value: if sorted.len() < 3 { 2.0 * PI } else { gap },
                why: "give at least three directions around the contact, less than pi apart",
            });
        }
        let spokes: Vec<_> = sorted
            .iter()
            .map(|&(angle, mu)| (Vector2::new(angle.cos(), angle.sin()), mu))
            .collect();
        let hull = edges(&convex_hull(spokes.iter().map(|(d, mu)| *mu * d).collect()));
        Ok(Self { spokes, hull })
    }

    /// `count` directions from angle 0 on, all with coefficient `mu`: the circle's inner polygon,
    /// with coefficients down to `mu cos(pi / count)` between the directions.
    ///
    /// # Errors
    /// [`ContactError::Invalid`] where [`Self::new`] refuses.
    pub fn regular(mu: f64, count: usize) -> Result<Self, ContactError> {
        let spokes: Vec<_> = (0..count).map(|i| (2.0 * PI * i as f64 / count as f64, mu)).collect();
        Self::new(&spokes)
    }

    /// Whether there is no friction at all.
    pub(crate) fn is_frictionless(&self) -> bool {
        self.spokes.iter().all(|(_, mu)| *mu == 0.0)
    }

    /// The polygon (8.48) as other solvers see it.
    pub(crate) fn limit_curve(&self) -> Result<LimitCurve, ContactError> {
        let points: Vec<_> = self.spokes.iter().map(|(direction, mu)| *mu * direction).collect();
        Ok(LimitCurve::Polygon(limit_curve::Polygon::new(&points)?))
    }

    /// The forces that the curve allows per unit of normal force, as `a . p <= b`: the polygon of
    /// (8.48), or as printed the half planes `d_b . p <= mu_b` of (8.63).
    #[must_use]
    pub fn half_planes(&self, form: Form) -> &[(Vector2<f64>, f64)] {
        match form {
            Form::AsPrinted => &self.spokes,
            Form::Corrected => &self.hull,
        }
    }
}

/// Corners of the convex hull of `points` and the origin, counterclockwise (Andrew's chains).
fn convex_hull(mut points: Vec<Vector2<f64>>) -> Vec<Vector2<f64>> {
    points.push(Vector2::zeros());
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let size = points.iter().map(Vector2::norm).fold(0.0, f64::max);
    let chain = |points: &mut dyn Iterator<Item = &Vector2<f64>>| {
        let mut corners: Vec<Vector2<f64>> = Vec::new();
        for point in points {
            while let [.., a, b] = corners[..] {
                if (b - a).perp(&(point - b)) > 1e-14 * size * size {
                    break;
                }
                corners.pop();
            }
            corners.push(*point);
        }
        corners.pop();
        corners
    };
    let mut hull = chain(&mut points.iter());
    hull.extend(chain(&mut points.iter().rev()));
    hull
}

/// Outward edges of a polygon. A segment or a point gets edges along the four directions of its own
/// frame, so that it is bounded as well.
fn edges(corners: &[Vector2<f64>]) -> Vec<(Vector2<f64>, f64)> {
    let support =
        |a: Vector2<f64>| (a, corners.iter().map(|c| a.dot(c)).fold(f64::NEG_INFINITY, f64::max));
    let along = match corners {
        [a, b] => (b - a).try_normalize(0.0).unwrap_or_else(Vector2::x),
        [_] | [] => Vector2::x(),
        _ => {
            let next = corners.iter().cycle().skip(1);
            return corners
                .iter()
                .zip(next)
                .map(|(a, b)| {
                    let edge = (b - a).normalize();
                    let outward = Vector2::new(edge.y, -edge.x);
                    (outward, outward.dot(a))
                })
                .collect();
        }
    };
    let across = Vector2::new(-along.y, along.x);
    [along, -along, across, -across].map(support).to_vec()
}
