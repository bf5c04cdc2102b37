use nalgebra::Vector2;

/// The friction that a contact can bear per normal force, by direction: a closed convex curve about
/// the origin of the tangent plane.
#[derive(Debug, Clone, PartialEq)]
pub enum LimitCurve {
    /// The same in all directions.
    Circle {
        /// Coefficient of friction.
        mu: f64,
    },
    /// Different along `t1` and `t2`.
    Ellipse {
        /// Coefficients along `t1` and along `t2`.
        mu: [f64; 2],
    },
}

impl LimitCurve {
    /// The point of the curve's inside, scaled by `scale >= 0`, that is nearest to `p`.
    #[must_use]
    pub fn project(&self, p: &Vector2<f64>, scale: f64) -> Vector2<f64> {
        match self {
            Self::Circle { mu } => {
                let (radius, norm) = (mu * scale, p.norm());
                if norm <= radius { *p } else { p * (radius / norm) }
            }
            Self::Ellipse { .. } => todo!(),
        }
    }
}
