use super::{ChainForm, CylinderChain, Root};
use crate::RigidBody;
use crate::thesis::projection::Form;
use nalgebra::{Matrix3, Point3, Rotation3, SMatrix, Vector3};
use rapunzel_fiber::so3::{self, hat};

/// A segment in a step: what it does without its joints' impulses, and what these change.
#[derive(Debug, Clone)]
pub(super) struct ChainLink {
    dt: f64,
    pub(super) mass: f64,
    /// The turn's rate per angular impulse, and the rate of the spin about the axis that is beside
    /// it.
    inverse_inertia: Matrix3<f64>,
    spin_rate: f64,
    /// From the center to the end towards the tip at the start of the step.
    pub(super) lever: Vector3<f64>,
    rotation: Rotation3<f64>,
    /// Center, rotation vector and spin of the step without the joints' impulses.
    free_center: Vector3<f64>,
    free_turn: Vector3<f64>,
    free_spin: f64,
    /// At the end of the step: center, frame, lever.
    pub(super) center: Vector3<f64>,
    pub(super) frame: Rotation3<f64>,
    pub(super) arm: Vector3<f64>,
    /// The turn at the end of the step per angular impulse: `dt J_l(phi) I^-1`, and the spin's
    /// part.
    turn: Matrix3<f64>,
}

impl ChainLink {
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
        let mass = segment.mass();
        let rotation = segment.pose.rotation.to_rotation_matrix();
        let share = if form.contact_time.is_corrected() { 1.0 } else { 0.5 };
        let velocity = segment.velocity + (0.5 * dt * force + share * contact[0]) / mass;
        let momentum = segment.angular_momentum + angular + share * contact[1];
        let (inverse_inertia, spin_rate) = inverse_inertia(segment, form);
        let mut link = Self {
            dt,
            mass,
            inverse_inertia,
            spin_rate,
            lever: rotation * Vector3::new(0.0, 0.0, half_length),
            rotation,
            free_center: segment.pose.translation.vector + dt * velocity,
            free_turn: dt * (inverse_inertia * momentum),
            free_spin: dt * spin_rate * rotation.matrix().column(2).dot(&momentum),
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
        let (turn, spin) = self.step_turn(angular);
        let step = so3::exp(&turn);
        self.frame = step * self.rotation * Rotation3::from_axis_angle(&Vector3::z_axis(), spin);
        self.arm = step * self.lever;
        self.turn = so3::right_jacobian(&-turn) * self.inverse_inertia * self.dt;
        let (axis, new) = (self.rotation.matrix().column(2), self.frame.matrix().column(2));
        self.turn += (self.dt * self.spin_rate * new) * axis.transpose();
    }

    /// Sets `turn` and the arm to their values at the start of the step: the linearization of
    /// method II.
    pub(super) fn linearize(&mut self) {
        self.arm = self.lever;
        let axis = self.rotation.matrix().column(2);
        self.turn = (self.inverse_inertia + (self.spin_rate * axis) * axis.transpose()) * self.dt;
    }

    /// The rotation vector of the step under `angular`, and the angle about the segment's own axis
    /// that comes before it.
    pub(super) fn step_turn(&self, angular: &Vector3<f64>) -> (Vector3<f64>, f64) {
        let turn = self.free_turn + self.dt * (self.inverse_inertia * angular);
        let along = self.rotation.matrix().column(2).dot(angular);
        (turn, self.free_spin + self.dt * self.spin_rate * along)
    }

    /// The end at `side` (+1 tip, -1 root) at the end of the step.
    pub(super) fn end(&self, side: f64) -> Vector3<f64> {
        self.center + side * self.arm
    }

    /// Derivative by the impulse at the joint at `from` of the constraint of the joint at `at`;
    /// `bend` is the derivative of the relative rotation vector. Sides are +1 (tip) and -1 (root),
    /// and these are also the signs with which the segment enters either.
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

/// The rate of turning per angular momentum, and the rate of the spin about the axis beside it.
///
/// Corrected: a free cylinder turns about its momentum with `L / I_1` and spins in its own frame
/// with `(1/I_3 - 1/I_1) L_3`, both constant, however fast. The axial moment of a hair's segment is
/// a thousandth of the other; friction that rolls it spins it by radians in a step, and a turn by
/// `I^-1 L` as a whole would drag the axis along.
fn inverse_inertia(segment: &RigidBody, form: &ChainForm) -> (Matrix3<f64>, f64) {
    let inverse = segment.inverse_inertia();
    match form.gyroscopic {
        Form::AsPrinted => (inverse, 0.0),
        Form::Corrected => {
            let [first, axis] = [Vector3::x(), Vector3::z()].map(|a| segment.pose.rotation * a);
            // Each from where it is the larger one.
            let across = 1.0 / first.dot(&(segment.inertia() * first));
            let along = axis.dot(&(inverse * axis));
            (Matrix3::from_diagonal_element(across), along - across)
        }
    }
}

/// Point at which the root is held, world, m, and the frame in which it is clamped.
pub(super) fn wall(chain: &CylinderChain) -> Option<(Point3<f64>, Option<Rotation3<f64>>)> {
    match chain.root {
        Root::Free => None,
        Root::Hinged(point) => Some((point, None)),
        Root::Clamped(pose) => {
            Some((pose.translation.vector.into(), Some(pose.rotation.to_rotation_matrix())))
        }
    }
}
