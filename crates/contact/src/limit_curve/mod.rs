use crate::ContactError;
use nalgebra::Vector2;

mod between;
mod cone;
mod ellipse;
mod friction;
mod polygon;

pub use friction::Friction;
pub use polygon::Polygon;

/// The friction that a contact can bear per normal force, by direction: a closed convex curve about
/// the origin of the tangent plane.
///
/// A point of the curve is a friction *on the first* of the two that touch, along `t1` and `t2` of
/// the contact's frame; it works against a slip of the first along the curve's inward normal there.
/// Coefficients may be zero: a curve may be a segment, or the origin alone. Cloning is cheap.
#[derive(Debug, Clone, PartialEq)]
pub enum LimitCurve {
    /// One coefficient in all directions.
    Circle {
        /// Coefficient of friction.
        mu: f64,
    },
    /// Different along `t1` and `t2`, thesis (8.47).
    Ellipse {
        /// Coefficients along `t1` and along `t2`.
        mu: [f64; 2],
    },
    /// Four quarter-ellipses that join on the axes: different in both senses of `t1` and `t2`.
    Quarters {
        /// Coefficients of friction along `t1`, `-t1`, `t2`, `-t2`: against slips of the first
        /// along `-t1`, `t1`, `-t2`, `t2`.
        mu: [f64; 4],
    },
    /// A convex polygon, thesis (8.48).
    Polygon(Polygon),
    /// No limit: a contact with it is a joint that holds two points together in all directions,
    /// along the normal too.
    Joint,
}

impl LimitCurve {
    /// Friction of a fiber, the first, whose axis from root to tip is `t1`.
    ///
    /// `with` resists a fiber that moves root first, along `-t1`: what it touches strokes it from
    /// root to tip, with the scales. `against` resists a fiber that moves tip first, `across` one
    /// that moves sideways. All must be finite and not negative ([`Self::validate`]).
    #[must_use]
    pub fn cuticle(with: f64, against: f64, across: f64) -> Self {
        Self::Quarters { mu: [with, against, across, across] }
    }

    /// Checks the coefficients.
    ///
    /// # Errors
    /// [`ContactError::Invalid`] for a coefficient that is negative or not finite.
    pub fn validate(&self) -> Result<(), ContactError> {
        let mu: &[f64] = match self {
            Self::Circle { mu } => std::slice::from_ref(mu),
            Self::Ellipse { mu } => mu,
            Self::Quarters { mu } => mu,
            Self::Polygon(_) | Self::Joint => &[],
        };
        match mu.iter().find(|mu| !(mu.is_finite() && **mu >= 0.0)) {
            Some(&value) => Err(ContactError::Invalid {
                what: "coefficient of friction",
                value,
                why: "it must be finite and not negative",
            }),
            None => Ok(()),
        }
    }

    /// The curve of the same contact seen from the second: friction on it is the opposite.
    #[must_use]
    pub fn reflected(&self) -> Self {
        match self {
            Self::Circle { .. } | Self::Ellipse { .. } | Self::Joint => self.clone(),
            Self::Quarters { mu: [a, b, c, d] } => Self::Quarters { mu: [*b, *a, *d, *c] },
            Self::Polygon(polygon) => Self::Polygon(polygon.reflected()),
        }
    }

    /// The point of the curve's inside, scaled by `scale >= 0`, that is nearest to `p`.
    ///
    /// Closed form for a circle and, per edge, a polygon; otherwise three to five steps of a
    /// monotone Newton iteration. Errors are of the order of rounding.
    #[must_use]
    #[inline(always)]
    pub fn project(&self, p: &Vector2<f64>, scale: f64) -> Vector2<f64> {
        if scale <= 0.0 && *self != Self::Joint {
            return Vector2::zeros();
        }
        match self {
            Self::Circle { mu } => {
                let (radius, square) = (mu * scale, p.norm_squared());
                if square <= radius * radius { *p } else { p * (radius / square.sqrt()) }
            }
            // Solvers ask most for circles, and should not carry all this along.
            curve => curve.search_nearest(p, scale),
        }
    }

    /// Projection onto a curve that is no circle.
    #[inline(never)]
    fn search_nearest(&self, p: &Vector2<f64>, scale: f64) -> Vector2<f64> {
        match self {
            Self::Polygon(polygon) => return polygon.project(p, scale),
            Self::Joint => return *p,
            _ => {}
        }
        let semi = quarter(&self.semi_axes().unwrap_or_default(), p);
        ellipse::project(p, semi.map(|semi| semi * scale))
    }

    /// Friction per normal force of maximal dissipation against `slip`, thesis (8.54): the point of
    /// the curve with outward normal `-slip` (erratum to (8.55)).
    ///
    /// Where a whole edge of a polygon dissipates the same it is the vertex that comes first in the
    /// polygon's order. Without slip, and for a joint, it is zero.
    #[must_use]
    pub fn friction(&self, slip: &Vector2<f64>) -> Vector2<f64> {
        match self {
            Self::Circle { mu } => {
                let speed = slip.norm();
                if speed > 0.0 { slip * (-mu / speed) } else { Vector2::zeros() }
            }
            Self::Ellipse { mu } => ellipse::support(&-slip, *mu),
            Self::Quarters { mu } => ellipse::support(&-slip, quarter(mu, &-slip)),
            Self::Polygon(polygon) => polygon.support(&-slip),
            Self::Joint => Vector2::zeros(),
        }
    }

    /// Power per normal force that friction takes out of `slip`, m/s: the curve's support function
    /// at `-slip`.
    #[must_use]
    pub fn dissipation(&self, slip: &Vector2<f64>) -> f64 {
        match self {
            Self::Circle { mu } => mu * slip.norm(),
            _ => -self.friction(slip).dot(slip),
        }
    }

    /// Factor by which the curve must be scaled to pass through `p`; infinite where none does.
    #[must_use]
    pub fn gauge(&self, p: &Vector2<f64>) -> f64 {
        match self {
            Self::Circle { mu } => ellipse::gauge(p, [*mu; 2]),
            Self::Ellipse { mu } => ellipse::gauge(p, *mu),
            Self::Quarters { mu } => ellipse::gauge(p, quarter(mu, p)),
            Self::Polygon(polygon) => polygon.gauge(p),
            Self::Joint => 0.0,
        }
    }

    /// Whether `p` is inside the curve scaled by `scale >= 0`, or on it.
    #[must_use]
    #[inline]
    pub fn contains(&self, p: &Vector2<f64>, scale: f64) -> bool {
        if let Self::Circle { mu } = self
            && *mu > 0.0
        {
            // Without the quotients of the gauge, as solvers ask for every contact that sticks.
            return p.norm() <= mu * scale;
        }
        self.gauge(p) <= scale
    }

    /// The semi-axes along `t1`, `-t1`, `t2`, `-t2` of a curve that is made of quarter-ellipses.
    pub(crate) fn semi_axes(&self) -> Option<[f64; 4]> {
        match self {
            Self::Circle { mu } => Some([*mu; 4]),
            Self::Ellipse { mu: [a, b] } => Some([*a, *a, *b, *b]),
            Self::Quarters { mu } => Some(*mu),
            Self::Polygon(_) | Self::Joint => None,
        }
    }
}

/// Semi-axes of the quarter in which `p` lies.
fn quarter(mu: &[f64; 4], p: &Vector2<f64>) -> [f64; 2] {
    [if p.x >= 0.0 { mu[0] } else { mu[1] }, if p.y >= 0.0 { mu[2] } else { mu[3] }]
}
