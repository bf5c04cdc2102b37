use crate::contact::velocities::Velocities;
use crate::contact_point::ContactPoint;
use nalgebra::Vector3;
use rapunzel_contact::{Contact, LimitCurve};

/// What a contact obeys; where it is, its contact point tells. A [`Contact`] of each would be more
/// than twice as large, and most of a dense list are never solved.
pub(super) struct ContactParameters {
    pub(super) bias: Vector3<f64>,
    pub(super) friction: LimitCurve,
    pub(super) adhesion: f64,
    pub(super) compliance: f64,
    /// The gap at the start of the step over its length, m/s.
    pub(super) gap: f64,
}

impl ContactParameters {
    /// A joint at a contact point, with what its relative velocity must be, m/s, world, for it to
    /// be closed at the end of the step: the opposite of `bias`.
    pub(super) fn joint(point: &ContactPoint, bias: Vector3<f64>) -> Self {
        let bias = point.frame().tr_mul(&bias);
        let (friction, gap) = (LimitCurve::Joint, bias.x);
        Self { bias, friction, adhesion: 0.0, compliance: 0.0, gap }
    }

    /// What bends at a joint, and gives way by a compliance, 1/kg; its bias is still to be found.
    pub(super) fn couple(compliance: f64) -> Self {
        let (bias, friction) = (Vector3::zeros(), LimitCurve::Joint);
        Self { bias, friction, adhesion: 0.0, compliance, gap: 0.0 }
    }

    pub(super) fn is_joint(&self) -> bool {
        self.friction == LimitCurve::Joint
    }

    /// The contact of a contact point, as a solver takes it, between two points.
    pub(super) fn contact(&self, point: &ContactPoint, [first, second]: [usize; 2]) -> Contact {
        Contact {
            first,
            second: (!point.kinematic).then_some(second),
            frame: point.frame(),
            bias: self.bias,
            friction: self.friction.clone(),
            adhesion: self.adhesion,
            compliance: self.compliance,
        }
    }

    /// The relative velocity of the contact along its normal, with its bias, m/s.
    pub(super) fn opening(&self, point: &ContactPoint, velocities: &Velocities) -> f64 {
        point.normal.dot(&velocities.between(point)) + self.bias.x
    }
}
