//! Stiffness, mass and displacements of the whole chain, before constraints.

use crate::JointAction;
use crate::joint::Joint;
use crate::{End, Instant, Load, RodState};
use nalgebra::{DMatrix, Matrix3, Rotation3, Vector3};
use rapunzel_fiber::{Fiber, so3};

/// A chain in equilibrium and the conditions on it.
pub(super) struct LinearAssembly<'a> {
    fiber: &'a Fiber,
    conditions: &'a Instant,
    frames: &'a [Rotation3<f64>],
    /// Force in each segment that the part beyond exerts on the part before, N, world.
    forces: Vec<Vector3<f64>>,
    /// Moment and Hessian of joint `j` of `0..=n`; `None` where an end is free to turn.
    joints: Vec<Option<JointAction>>,
    /// First row of the segments: 3 behind the displacement of a free root, else 0.
    first: usize,
}

impl<'a> LinearAssembly<'a> {
    pub(super) fn new(fiber: &'a Fiber, conditions: &'a Instant, state: &'a RodState) -> Self {
        let (n, frames) = (fiber.segments(), &state.frames);
        let pose = |end: &End| match end {
            End::Held(pose) => Some(pose.rotation.to_rotation_matrix()),
            _ => None,
        };
        let joints = (0..=n).map(|j| {
            let before = if j == 0 { pose(&conditions.root) } else { Some(frames[j - 1]) };
            let behind = if j == n { pose(&conditions.tip) } else { Some(frames[j]) };
            Some(Joint::new(fiber, j).act(&before?, &behind?))
        });
        let first = if matches!(conditions.root, End::Loaded { .. }) { 3 } else { 0 };
        let forces = vec![Vector3::zeros(); n];
        let joints = joints.collect();
        let mut chain = Self { fiber, conditions, frames, forces, joints, first };
        chain.forces[n - 1] = match conditions.tip {
            End::Loaded { force, .. } => world(&force, &frames[n - 1]) + chain.weight(n - 1),
            _ => state.forces[n - 1],
        };
        for e in (0..n - 1).rev() {
            chain.forces[e] = chain.forces[e + 1] + chain.weight(e) + chain.weight(e + 1);
        }
        chain
    }

    /// Half of the weight and distributed load on segment `e`, N, world: the share of each of its
    /// nodes.
    fn weight(&self, e: usize) -> Vector3<f64> {
        let h = self.fiber.segment_lengths()[e];
        let Instant { gravity, distributed, .. } = self.conditions;
        0.5 * (self.fiber.segment_mass(e) * gravity + h * distributed)
    }

    fn size(&self) -> usize {
        self.first + 3 * self.frames.len()
    }

    fn row(&self, e: usize) -> usize {
        self.first + 3 * e
    }

    /// Vector along segment `e`, from its first to its second node, m, world.
    fn lever(&self, e: usize) -> Vector3<f64> {
        self.fiber.segment_lengths()[e] * self.frames[e].matrix().column(2)
    }

    /// Largest imbalance, N m: of the torque on a segment, or of the force on a free root times the
    /// rod's length.
    pub(super) fn imbalance(&self) -> f64 {
        let n = self.frames.len();
        let mut largest = 0.0_f64;
        if let End::Loaded { force, .. } = &self.conditions.root {
            let pull = self.forces[0] + self.weight(0) + world(force, &self.frames[0]);
            largest = pull.amax() * self.fiber.length();
        }
        for e in 0..n {
            let moment = |j: usize| self.joints[j].as_ref().map_or(Vector3::zeros(), |a| a.moment);
            let mut torque = moment(e + 1) - moment(e) + self.lever(e).cross(&self.forces[e]);
            for (at, end) in [(0, &self.conditions.root), (n - 1, &self.conditions.tip)] {
                if let (true, End::Loaded { moment, .. }) = (e == at, end) {
                    torque += world(moment, &self.frames[e]);
                }
            }
            largest = largest.max(torque.amax());
        }
        largest
    }

    /// Stiffness matrix: the second derivative of the energy of joints and dead forces by the
    /// increments, and the terms of end loads without a potential.
    pub(super) fn stiffness(&self) -> DMatrix<f64> {
        let n = self.frames.len();
        let mut k = DMatrix::zeros(self.size(), self.size());
        let mut add = |i: usize, j: usize, block: Matrix3<f64>| {
            let mut view = k.fixed_view_mut::<3, 3>(i, j);
            view += block;
        };
        // Joints: H on the diagonal, hat(M)/2 - H between neighbouring segments.
        for (j, action) in self.joints.iter().enumerate() {
            let Some(JointAction { moment, hessian }) = action else { continue };
            if j > 0 {
                add(self.row(j - 1), self.row(j - 1), *hessian);
            }
            if j < n {
                add(self.row(j), self.row(j), *hessian);
            }
            if j > 0 && j < n {
                // Two rotations do not commute: half the moment stays between them.
                let coupling = 0.5 * so3::hat(moment) - hessian;
                add(self.row(j - 1), self.row(j), coupling);
                add(self.row(j), self.row(j - 1), coupling.transpose());
            }
        }
        // Forces p on the segment vectors d: (p d) E - sym(p d^T).
        for e in 0..n {
            let (p, d) = (self.forces[e], self.lever(e));
            let outer = p * d.transpose();
            let geometric = Matrix3::from_diagonal_element(p.dot(&d));
            add(self.row(e), self.row(e), geometric - 0.5 * (outer + outer.transpose()));
        }
        // Moments and follower forces at the ends.
        for (e, end) in [(0, &self.conditions.root), (n - 1, &self.conditions.tip)] {
            let End::Loaded { force, moment } = end else { continue };
            let turning = match moment {
                Load::World(m) => -0.5 * so3::hat(m),
                Load::Follower(m) => 0.5 * so3::hat(&(self.frames[e] * m)),
            };
            add(self.row(e), self.row(e), turning);
            if let Load::Follower(f) = force {
                // The force turns with its segment and works on all that moves its node.
                let turned = so3::hat(&(self.frames[e] * f));
                if self.first > 0 {
                    add(0, self.row(e), turned);
                }
                for before in (0..n).filter(|_| e > 0) {
                    add(self.row(before), self.row(e), so3::hat(&self.lever(before)) * turned);
                }
            }
        }
        k
    }

    /// Displacements of the nodes (three rows each, m) per increment (columns).
    pub(super) fn displacement(&self) -> DMatrix<f64> {
        let n = self.frames.len();
        let mut displacement = DMatrix::zeros(3 * (n + 1), self.size());
        for a in 0..=n {
            if self.first > 0 {
                displacement.fixed_view_mut::<3, 3>(3 * a, 0).fill_with_identity();
            }
            for e in 0..a {
                let block = -so3::hat(&self.lever(e));
                displacement.fixed_view_mut::<3, 3>(3 * a, self.row(e)).copy_from(&block);
            }
        }
        displacement
    }

    /// Mass matrix of the lumped nodes and of the directors, whose inertia is in the kinetic energy
    /// `rho (I2 |d1'|^2 + I1 |d2'|^2) / 2` of a section.
    pub(super) fn mass(&self, displacement: &DMatrix<f64>) -> DMatrix<f64> {
        let (n, nodes) = (self.frames.len(), self.fiber.nodes());
        // Lumped masses of the nodes.
        let mut weighted = displacement.clone();
        for a in 0..=n {
            let sides = [a.checked_sub(1), (a < n).then_some(a)];
            let lumped: f64 =
                sides.into_iter().flatten().map(|e| 0.5 * self.fiber.segment_mass(e)).sum();
            weighted.rows_mut(3 * a, 3).scale_mut(lumped);
        }
        let mut mass = displacement.tr_mul(&weighted);
        // Inertia of the directors.
        for e in 0..n {
            let density = 0.5 * (nodes[e].rotary_inertia + nodes[e + 1].rotary_inertia);
            let inertia = density * self.fiber.segment_lengths()[e];
            let mut block = mass.fixed_view_mut::<3, 3>(self.row(e), self.row(e));
            for (k, inertia) in [(0, inertia.y), (1, inertia.x)] {
                let d = self.frames[e].matrix().column(k);
                block += inertia * (Matrix3::identity() - d * d.transpose());
            }
        }
        mass
    }
}

/// World components of a load at an end whose frame is `frame`.
fn world(load: &Load, frame: &Rotation3<f64>) -> Vector3<f64> {
    match load {
        Load::World(v) => *v,
        Load::Follower(v) => frame * v,
    }
}
