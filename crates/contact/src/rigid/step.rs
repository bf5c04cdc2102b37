use super::RigidBody;
use crate::ContactError;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rapunzel_fiber::so3;

/// Newton's iterations for the midpoint: it converges quadratically from turns of a radian.
const MIDPOINT_ITERATIONS: usize = 20;

impl RigidBody {
    /// Moves on by `dt` (s) under a `force` (N) and a `moment` (N m, about the center of mass),
    /// both in the world's frame and constant over the step.
    ///
    /// Linear motion is exact. The rotation is the implicit midpoint rule on SO(3) with the exact
    /// exponential, `R' = exp(dt omega_m) R`, `omega_m = I_m^-1 L_m` with the inertia half way
    /// along the same rotation: second order, reversible in time, and the momenta change by
    /// `dt force` and `dt moment` to rounding. (8.80), corrected: the gyroscopic term is in the
    /// turning of `I_m`. (The exponential multiplies on the left: omega is in the world's frame.)
    ///
    /// # Errors
    /// [`ContactError::Invalid`] if the body turns so far in the step (more than about half a
    /// turn) that the midpoint is not found; the body is then as before.
    pub fn step(
        &mut self,
        force: &Vector3<f64>,
        moment: &Vector3<f64>,
        dt: f64,
    ) -> Result<(), ContactError> {
        let middle = self.angular_momentum + 0.5 * dt * moment;
        let turn = self.midpoint_turn(&middle, dt)?;
        self.pose.rotation *= UnitQuaternion::from_scaled_axis(turn);
        self.pose.rotation.renormalize();
        self.angular_momentum += dt * moment;
        let acceleration = force / self.mass;
        self.pose.translation.vector += dt * (self.velocity + 0.5 * dt * acceleration);
        self.velocity += dt * acceleration;
        Ok(())
    }

    /// The rotation vector of the step in the body's frame, `theta`, from
    /// `I theta = dt exp(-theta/2) R^T L_m`.
    fn midpoint_turn(
        &self,
        momentum: &Vector3<f64>,
        dt: f64,
    ) -> Result<Vector3<f64>, ContactError> {
        let scaled = dt * self.pose.rotation.inverse_transform_vector(momentum);
        let mut turn = self.inverse_inertia * scaled;
        for _ in 0..MIDPOINT_ITERATIONS {
            let half = -0.5 * turn;
            let back = so3::exp(&half);
            let residual = self.inertia * turn - back * scaled;
            let slope =
                self.inertia - 0.5 * back.matrix() * so3::hat(&scaled) * so3::right_jacobian(&half);
            let Some(correction) = slope.lu().solve(&residual) else { break };
            turn -= correction;
            if correction.norm() <= 4.0 * f64::EPSILON * turn.norm() {
                return Ok(turn);
            }
        }
        Err(ContactError::Invalid {
            what: "turn of a rigid body in one step, rad",
            value: (self.inverse_inertia * scaled).norm(),
            why: "take a shorter step: the body must turn by less than about half a turn",
        })
    }

    /// Moves on by `dt` with the given velocities of the body (world), leaving its velocity and
    /// angular momentum as they are.
    pub(crate) fn drift(&mut self, velocity: &Vector3<f64>, omega: &Vector3<f64>, dt: f64) {
        self.turn(&(dt * omega));
        self.pose.translation = Translation3::from(self.pose.translation.vector + dt * velocity);
    }

    /// Turns by the rotation vector `turn` (world).
    pub(crate) fn turn(&mut self, turn: &Vector3<f64>) {
        self.pose.rotation = UnitQuaternion::from_scaled_axis(*turn) * self.pose.rotation;
        self.pose.rotation.renormalize();
    }
}
