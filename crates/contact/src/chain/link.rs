use super::{Chain, ChainForm, Root};
use crate::RigidBody;
use crate::projection::Form;
use nalgebra::{Matrix3, Point3, Rotation3, SMatrix, Vector3};
use rapunzel_fiber::so3::{self, hat};

/// A segment in a step: what it does without its joints' impulses, and what these change.
#[derive(Debug, Clone)]
pub(super) struct Link {
    dt: f64,
    pub(super) mass: f64,
    pub(super) inverse_inertia: Matrix3<f64>,
    /// From the center to the end towards the tip at the start of the step.
    pub(super) lever: Vector3<f64>,
    rotation: Rotation3<f64>,
    /// Center and rotation vector of the step without the joints' impulses.
    free_center: Vector3<f64>,
    free_turn: Vector3<f64>,
    /// At the end of the step: center, frame, lever.
    pub(super) center: Vector3<f64>,
    pub(super) frame: Rotation3<f64>,
    pub(super) arm: Vector3<f64>,
    /// `dt J_l(phi) I^-1`: the turn at the end of the step per angular impulse.
    turn: Matrix3<f64>,
}

impl Link {
    /// `angular` is the springs' impulse, N m s; `contact` are the contacts' impulses.
    pub(super) fn new(
        segment: &RigidBody,
        half_length: f64,
        force: &Vector3<f64>,
        angular: &Vector3<f64>,
        contact: &[Vector3<f64>; 2],
        dt: f64,
        form: &ChainForm,
    ) -> Self {
        let inverse_inertia = segment.inverse_inertia();
        let (mass, omega) = (segment.mass(), segment.angular_velocity());
        let rotation = segment.pose.rotation.to_rotation_matrix();
        let moment = gyroscopic_moment(segment, form);
        let share = if form.contact_time.is_corrected() { 1.0 } else { 0.5 };
        let velocity = segment.velocity + (0.5 * dt * force + share * contact[0]) / mass;
        let rate = omega + inverse_inertia * (0.5 * dt * moment + angular + share * contact[1]);
        let mut link = Self {
            dt,
            mass,
            inverse_inertia,
            lever: rotation * Vector3::new(0.0, 0.0, half_length),
            rotation,
            free_center: segment.pose.translation.vector + dt * velocity,
            free_turn: dt * rate,
            center: Vector3::zeros(),
            frame: rotation,
            arm: Vector3::zeros(),
            turn: Matrix3::zeros(),
        };
        link.move_on(&Vector3::zeros(), &Vector3::zeros());
        link
    }

    /// Goes to the end of the step under the sums of the joints' impulses.
    pub(super) fn move_on(&mut self, impulse: &Vector3<f64>, angular: &Vector3<f64>) {
        self.center = self.free_center + self.dt / self.mass * impulse;
        let turn = self.free_turn + self.dt * (self.inverse_inertia * angular);
        let step = so3::exp(&turn);
        self.frame = step * self.rotation;
        self.arm = step * self.lever;
        self.turn = so3::right_jacobian(&-turn) * self.inverse_inertia * self.dt;
    }

    /// As [`Self::turn`] and the arm at the start of the step: the linearization of method II.
    pub(super) fn linearize(&mut self) {
        self.arm = self.lever;
        self.turn = self.inverse_inertia * self.dt;
    }

    /// The rotation vector of the step under `angular`.
    pub(super) fn step_turn(&self, angular: &Vector3<f64>) -> Vector3<f64> {
        self.free_turn + self.dt * (self.inverse_inertia * angular)
    }

    /// The end at `side` (+1 tip, -1 root) at the end of the step.
    pub(super) fn end(&self, side: f64) -> Vector3<f64> {
        self.center + side * self.arm
    }

    /// How the impulse at the joint at `from` changes the constraint of the joint at `at`; `bend` is
    /// the derivative of the relative rotation vector. Sides are +1 (tip) and -1 (root), and these
    /// are also the signs with which the segment enters either.
    pub(super) fn couple<const D: usize>(
        &self,
        at: f64,
        from: f64,
        bend: &Matrix3<f64>,
    ) -> SMatrix<f64, D, D> {
        let mut block = SMatrix::<f64, D, D>::zeros();
        let sign = at * from;
        let lift = at * hat(&self.arm);
        let by_impulse = self.turn * (from * hat(&self.lever));
        let linear = Matrix3::from_diagonal_element(self.dt / self.mass) - lift * by_impulse;
        block.view_mut((0, 0), (3, 3)).copy_from(&(sign * linear));
        if D == 6 {
            block.view_mut((0, 3), (3, 3)).copy_from(&(-sign * lift * self.turn));
            block.view_mut((3, 0), (3, 3)).copy_from(&(sign * bend * by_impulse));
            block.view_mut((3, 3), (3, 3)).copy_from(&(sign * bend * self.turn));
        }
        block
    }
}

/// `-omega x I omega` of (8.80), corrected; world, N m.
pub(super) fn gyroscopic_moment(segment: &RigidBody, form: &ChainForm) -> Vector3<f64> {
    match form.gyroscopic {
        Form::AsPrinted => Vector3::zeros(),
        Form::Corrected => segment.angular_momentum.cross(&segment.angular_velocity()),
    }
}

/// Where the root is held, and in which frame.
pub(super) fn wall(chain: &Chain) -> Option<(Point3<f64>, Option<Rotation3<f64>>)> {
    match chain.root {
        Root::Free => None,
        Root::Hinged(point) => Some((point, None)),
        Root::Clamped(pose) => {
            Some((pose.translation.vector.into(), Some(pose.rotation.to_rotation_matrix())))
        }
    }
}
