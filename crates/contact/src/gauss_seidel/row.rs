use super::delassus::Delassus;
use crate::residual::slip_error;
use crate::{Contact, LimitCurve};
use nalgebra::{Matrix3, Vector2, Vector3};

/// What is read of a contact each time that it is looked at, side by side.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(super) struct Row {
    frame: Matrix3<f64>,
    bias: Vector3<f64>,
    pub(super) impulse: Vector3<f64>,
    pub(super) adhesion: f64,
    pub(super) compliance: f64,
    /// The mass that compares its impulse and its velocity, kg.
    pub(super) weight: f64,
    /// Coefficient of friction; none where it depends on the direction.
    mu: Option<f64>,
    pub(super) points: [u32; 2],
}

impl Row {
    pub(super) fn new(
        contact: &Contact,
        impulse: &Vector3<f64>,
        weight: f64,
        points: [u32; 2],
    ) -> Self {
        let mu = match contact.friction {
            LimitCurve::Circle { mu } => Some(mu),
            _ => None,
        };
        let Contact { frame, bias, adhesion, compliance, .. } = *contact;
        Self { frame, bias, impulse: *impulse, adhesion, compliance, weight, mu, points }
    }

    /// The square of the impulse from the tip of its cone.
    #[inline(always)]
    pub(super) fn square(&self) -> f64 {
        let (load, friction) = (self.impulse.x + self.adhesion, self.impulse.yz());
        load * load + friction.norm_squared()
    }

    /// Velocity of the first point relative to the second, in the frame, and the bias.
    #[inline(always)]
    pub(super) fn relative(&self, delassus: &Delassus) -> Vector3<f64> {
        let ([x, y, z], [n, s, t]) = (delassus.between(self.points), self.columns());
        let along = |axis: &[f64; 3]| axis[0] * x + axis[1] * y + axis[2] * z;
        Vector3::new(along(n) + self.bias.x, along(s) + self.bias.y, along(t) + self.bias.z)
    }

    /// An impulse out of the frame.
    #[inline(always)]
    pub(super) fn world(&self, impulse: &Vector3<f64>) -> Vector3<f64> {
        let [n, s, t] = self.columns();
        let along = |k: usize| n[k] * impulse.x + s[k] * impulse.y + t[k] * impulse.z;
        Vector3::new(along(0), along(1), along(2))
    }

    #[inline(always)]
    fn columns(&self) -> &[[f64; 3]; 3] {
        &self.frame.data.0
    }

    /// Whether [`slip_error`] is more than a bound.
    #[inline(always)]
    pub(super) fn slips(&self, contact: &Contact, velocity: &Vector3<f64>, bound: f64) -> bool {
        let Some(mu) = self.mu else {
            return slip_error(contact, velocity, &self.impulse, self.weight) > bound;
        };
        let (friction, slip, weight) = (self.impulse.yz(), velocity.yz(), self.weight);
        let wanted: Vector2<f64> = friction - slip * weight;
        let limit = mu * (self.impulse.x + self.adhesion).max(0.0);
        let (square, size) = (slip.norm_squared(), wanted.norm_squared());
        if size <= limit * limit {
            return square > bound * bound;
        }
        let missing = friction - wanted * (limit / size.sqrt());
        let along = missing.dot(&slip);
        along > 0.0 && along * along > square * (bound * weight) * (bound * weight)
    }
}
