use crate::{ContactError, LimitCurve};
use nalgebra::{Matrix3, Vector3};

/// A contact between two points, or between a point and something whose motion is given.
///
/// With `v` the velocities of the points, `u = frame^T (v_first - v_second) + bias` is the relative
/// velocity as the law sees it, and the impulse `r` on the first point, `-r` on the second, obeys
/// `0 <= r_n + adhesion`, `u_n >= 0`, one of them zero, and Coulomb's law of maximal dissipation:
/// `r_t` lies in the limit curve scaled by `r_n + adhesion` and is, of all that do, the one that
/// works most against `u_t`. Components 0, 1, 2 are normal, along `t1`, along `t2`. Of a joint,
/// [`LimitCurve::Joint`], the impulse is any with which `u` is zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// Index of the first point among the points of all bodies, in the order of the bodies.
    pub first: usize,
    /// Index of the second; `None` where the first touches something that is not moved by it.
    pub second: Option<usize>,
    /// Orthonormal and right-handed columns, world: the normal from the second to the first, then
    /// two tangents, of which the limit curve speaks.
    pub frame: Matrix3<f64>,
    /// Bias that is added to the relative velocity, m/s, in `frame`: minus the velocity of what is
    /// not moved; along the normal the gap that may still close in the step divided by its length,
    /// or the restitution's share of the velocity of approach.
    pub bias: Vector3<f64>,
    /// Friction by direction, per normal force.
    pub friction: LimitCurve,
    /// Tensile impulse that the contact can bear, N s.
    pub adhesion: f64,
    /// Compliance: adds `compliance * r` to the relative velocity, 1/kg. Zero is rigid.
    pub compliance: f64,
}

/// Largest entry by which `frame^T frame` may differ from the identity.
const ORTHONORMAL: f64 = 1e-9;

impl Contact {
    /// Whether it is a joint.
    #[must_use]
    pub fn is_joint(&self) -> bool {
        self.friction == LimitCurve::Joint
    }

    /// Relative velocity, m/s, in the contact's frame and with the bias, where the points have the
    /// given velocities, world.
    #[must_use]
    pub fn relative(&self, velocities: &[Vector3<f64>]) -> Vector3<f64> {
        let mut v = velocities[self.first];
        if let Some(second) = self.second {
            v -= velocities[second];
        }
        self.frame.tr_mul(&v) + self.bias
    }

    /// Checks contact number `index` of those between `points` points.
    ///
    /// # Errors
    /// [`ContactError::Contact`] for a point that there is not or that touches itself, a frame that
    /// is no rotation, and numbers that are not finite or, where they must not be, negative.
    pub fn validate(&self, index: usize, points: usize) -> Result<(), ContactError> {
        let finite = |numbers: &[f64]| numbers.iter().all(|x| x.is_finite());
        let error = (self.frame.tr_mul(&self.frame) - Matrix3::identity()).amax();
        let mirrored = self.frame.determinant() < 0.0;
        let why = if self.first.max(self.second.unwrap_or(0)) >= points {
            "a point is not among those of the bodies"
        } else if self.second == Some(self.first) {
            "a point cannot touch itself"
        } else if error > ORTHONORMAL || error.is_nan() || mirrored {
            "the columns of the frame must be orthonormal and right-handed"
        } else if !finite(self.bias.as_slice()) {
            "the bias must be finite"
        } else if !(finite(&[self.adhesion, self.compliance])
            && self.adhesion >= 0.0
            && self.compliance >= 0.0)
        {
            "adhesion and compliance must be finite and not negative"
        } else if self.friction.validate().is_err() {
            "coefficients of friction must be finite and not negative"
        } else {
            return Ok(());
        };
        Err(ContactError::Contact { contact: index, why })
    }
}
