use super::node_joint::{Connection, NodeJoint};
use nalgebra::{Matrix3, Matrix6, UnitQuaternion, Vector3};
use rapunzel_fiber::{Assembly, Fiber, so3};
use rapunzel_rod_dynamic::JointAction;

/// The elastic rod between the middles of two segments that are joined.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Junction {
    /// Rotation from the frame of the first segment to the frame from which the junction turns.
    pub(super) base: UnitQuaternion<f64>,
    /// Rotation vector without moment, rad.
    pub(super) rest: Vector3<f64>,
    /// Moment by rotation vector, N m.
    pub(crate) stiffness: Matrix3<f64>,
    /// Retardation time of internal damping, s.
    pub(crate) damping: f64,
}

/// Moment of a junction on its first segment, N m, world; on the second one acts the opposite. And
/// the second derivative of its energy by rotations of both, N m.
pub(crate) struct JunctionAction {
    pub(crate) moment: Vector3<f64>,
    pub(super) hessian: Matrix6<f64>,
}

impl Junction {
    /// What bends at a joint of fibres of an assembly, whose segments at it have these frames;
    /// nothing at a ball joint.
    pub(crate) fn new(
        joint: &NodeJoint,
        assembly: &Assembly,
        frames: [UnitQuaternion<f64>; 2],
    ) -> Option<Self> {
        let fibers = joint.places.map(|place| &assembly.fibers()[place.fiber]);
        let (damping, nodes) = (joint.damping_time, joint.places.map(|place| place.node));
        match joint.connection {
            Connection::Ball => None,
            Connection::Stiff => {
                let segments = joint.places.map(|place| place.segment());
                Some(Self::weld(fibers, segments, nodes, frames, damping))
            }
            Connection::Spliced { twist } => Some(Self::splice(fibers, damping, twist)),
        }
    }

    /// The junction of the tip of a fibre and the root of another, which continues the one as the
    /// other, as if both were one; first turned by `twist` (rad) about the tangent.
    fn splice([first, second]: [&Fiber; 2], damping: f64, twist: f64) -> Self {
        let last = first.segments();
        let lengths = [first.segment_lengths()[last - 1], second.segment_lengths()[0]];
        let nodes = [&first.nodes()[last], &second.nodes()[0]];
        let length = 0.5 * (lengths[0] + lengths[1]);
        let mean = |a: Vector3<f64>, b: Vector3<f64>| 0.5 * (a + b);
        Self {
            base: UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -twist),
            rest: mean(nodes[0].natural_curvature, nodes[1].natural_curvature) * length,
            stiffness: Matrix3::from_diagonal(
                &(mean(nodes[0].stiffness, nodes[1].stiffness) / length),
            ),
            damping,
        }
    }

    /// The junction of two segments that is without moment where they have these frames: half of
    /// each bends, of `fibers[i]` that at `segments[i]` with the stiffness at `nodes[i]`.
    fn weld(
        fibers: [&Fiber; 2],
        segments: [usize; 2],
        nodes: [usize; 2],
        frames: [UnitQuaternion<f64>; 2],
        damping: f64,
    ) -> Self {
        let base = frames[0].inverse() * frames[1];
        let turn = base.to_rotation_matrix().into_inner();
        let gives = |i: usize| {
            let half = 0.5 * fibers[i].segment_lengths()[segments[i]];
            let stiffness = fibers[i].nodes()[nodes[i]].stiffness;
            stiffness.map(|stiffness| half / stiffness)
        };
        let given = turn.transpose() * Matrix3::from_diagonal(&gives(0)) * turn
            + Matrix3::from_diagonal(&gives(1));
        // Of positive numbers a sum, which has an inverse.
        let stiffness = given.try_inverse().unwrap_or_else(Matrix3::zeros);
        Self { base, rest: Vector3::zeros(), stiffness, damping }
    }

    /// Rotation vector of the junction between these frames, rad.
    pub(crate) fn turn(&self, frames: [UnitQuaternion<f64>; 2]) -> Vector3<f64> {
        let [a, b] = self.frames(frames);
        so3::log(&(a.inverse() * b))
    }

    /// Elastic energy, J, of a rotation vector.
    pub(crate) fn stored(&self, turn: &Vector3<f64>) -> f64 {
        let strain = turn - self.rest;
        0.5 * strain.dot(&(self.stiffness * strain))
    }

    /// Work of the internal damping in a step of `dt` seconds, J; never positive.
    pub(crate) fn damped(&self, turns: [&Vector3<f64>; 2], dt: f64) -> f64 {
        let bend = turns[1] - turns[0];
        -self.damping / dt * bend.dot(&(self.stiffness * bend))
    }

    /// Action at the end of a step of `dt` seconds, at the start of which the junction had the
    /// rotation vector `before`. Its damping is that of the mean rate over the step.
    pub(crate) fn act(
        &self,
        frames: [UnitQuaternion<f64>; 2],
        before: &Vector3<f64>,
        dt: f64,
    ) -> JunctionAction {
        let [a, b] = self.frames(frames);
        let turn = so3::log(&(a.inverse() * b));
        let rate = self.damping / dt;
        let m = self.stiffness * (turn - self.rest + rate * (turn - before));
        let JointAction { moment, hessian } =
            JointAction::new(&a, &b, &m, &(self.stiffness * (1.0 + rate)));
        let beside = 0.5 * so3::hat(&moment) - hessian;
        let mut whole = Matrix6::zeros();
        whole.fixed_view_mut::<3, 3>(0, 0).copy_from(&hessian);
        whole.fixed_view_mut::<3, 3>(0, 3).copy_from(&beside);
        whole.fixed_view_mut::<3, 3>(3, 0).copy_from(&beside.transpose());
        whole.fixed_view_mut::<3, 3>(3, 3).copy_from(&hessian);
        JunctionAction { moment, hessian: whole }
    }

    /// With `root` of which the stiffness is the square, a matrix of which the elastic part of the
    /// second derivative of the energy at these frames is the product with its transpose, world.
    pub(crate) fn elastic_root(
        &self,
        root: &Matrix3<f64>,
        frames: [UnitQuaternion<f64>; 2],
    ) -> Matrix3<f64> {
        let [_, b] = self.frames(frames);
        b * so3::right_jacobian_inverse(&self.turn(frames)).transpose() * root
    }

    fn frames(&self, [a, b]: [UnitQuaternion<f64>; 2]) -> [nalgebra::Rotation3<f64>; 2] {
        [(a * self.base).to_rotation_matrix(), b.to_rotation_matrix()]
    }
}
