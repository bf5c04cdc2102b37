//! Reading and setting the state of one lane.

use super::array::{at, set};
use super::simd_batch::SimdBatch;
use crate::joint::Joint;
use crate::{Energy, Momentum, Rod, RodState};
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use pulp::Simd;
use rapunzel_fiber::so3;

impl<S: Simd> SimdBatch<S> {
    pub(super) fn vector(&self, a: &[S::f64s], i: usize, lane: usize) -> Vector3<f64> {
        Vector3::from_fn(|k, _| at(a, 3 * i + k, lane))
    }

    fn rotation(&self, e: usize, lane: usize) -> UnitQuaternion<f64> {
        let q = |i: usize| at(&self.chain.q, 4 * e + i, lane);
        UnitQuaternion::new_unchecked(Quaternion::new(q(3), q(0), q(1), q(2)))
    }

    /// Angular velocity of segment `e` in its material frame: half the sum of `d x d'`.
    fn angular_velocity(&self, e: usize, lane: usize, frame: &Rotation3<f64>) -> Vector3<f64> {
        let h = at(&self.chain.model.h, e, lane);
        let v = |a: usize| self.vector(&self.nodes.v, a, lane);
        let rates = [
            self.vector(&self.directors.v, 2 * e, lane),
            self.vector(&self.directors.v, 2 * e + 1, lane),
            (v(e + 1) - v(e)) / h,
        ];
        let mut sum = Vector3::zeros();
        for (k, rate) in rates.iter().enumerate() {
            sum += 0.5 * frame.matrix().column(k).cross(rate);
        }
        frame.inverse_transform_vector(&sum)
    }

    pub(super) fn state(&self, lane: usize, rod: &Rod, time: f64) -> RodState {
        let n = self.chain.n;
        let frames: Vec<_> = (0..n).map(|e| self.rotation(e, lane).to_rotation_matrix()).collect();
        let nodes = rod.fiber.nodes();
        let [root, tip] = self.chain.ends.joined(lane);
        let curvatures = (0..=n)
            .map(|j| {
                let rest = self.vector(&self.chain.model.rest, j, lane);
                if (j == 0 && !root) || (j == n && !tip) {
                    return nodes[j].natural_curvature;
                }
                let strain = self.vector(&self.phi, j, lane) - rest;
                nodes[j].natural_curvature + strain / Joint::new(&rod.fiber, j).length
            })
            .collect();
        RodState {
            time,
            positions: (0..=n).map(|a| self.vector(&self.r, a, lane).into()).collect(),
            velocities: (0..=n).map(|a| self.vector(&self.nodes.v, a, lane)).collect(),
            angular_velocities: frames
                .iter()
                .enumerate()
                .map(|(e, frame)| self.angular_velocity(e, lane, frame))
                .collect(),
            frames,
            forces: (0..n).map(|e| self.vector(&self.chain.force, e, lane)).collect(),
            curvatures,
        }
    }

    /// Starts one lane from `state`, whose arrays fit. Positions follow from the frames, and the
    /// strains of the joints at the ends from the curvatures there; at an end that is not clamped
    /// the curvature is the natural one, and the strain vanishes.
    pub(super) fn set_state(&mut self, lane: usize, rod: &Rod, state: &RodState) {
        let n = self.chain.n;
        for array in self.arrays_mut() {
            for i in 0..array.len() {
                set(array, i, lane, 0.0);
            }
        }
        let mut position = state.positions[0].coords;
        let mut before: Option<Rotation3<f64>> = None;
        for a in 0..=n {
            for i in 0..3 {
                set(&mut self.r, 3 * a + i, lane, position[i]);
                set(&mut self.nodes.v, 3 * a + i, lane, state.velocities[a][i]);
            }
            if a == n {
                break;
            }
            let frame = so3::quaternion(&state.frames[a]);
            let coordinates = frame.coords;
            for i in 0..4 {
                set(&mut self.chain.q, 4 * a + i, lane, coordinates[i]);
            }
            let matrix: Matrix3<f64> = frame.to_rotation_matrix().into_inner();
            let rates = matrix * so3::hat(&state.angular_velocities[a]);
            for k in 0..2 {
                for i in 0..3 {
                    set(&mut self.directors.v, 3 * (2 * a + k) + i, lane, rates[(i, k)]);
                }
            }
            position += matrix.column(2) * at(&self.chain.model.h, a, lane);
            let frame = Rotation3::from_matrix_unchecked(matrix);
            if let Some(before) = before {
                let turn = so3::log(&(before.inverse() * frame));
                self.set_turn(lane, a, &turn);
            }
            before = Some(frame);
        }
        self.chain.ends.join(lane);
        for j in [0, n] {
            let strain = state.curvatures[j] - rod.fiber.nodes()[j].natural_curvature;
            let turn = self.vector(&self.chain.model.rest, j, lane)
                + strain * Joint::new(&rod.fiber, j).length;
            self.set_turn(lane, j, &turn);
        }
        self.strain_laws_at_once(lane);
    }

    fn set_turn(&mut self, lane: usize, joint: usize, turn: &Vector3<f64>) {
        for i in 0..3 {
            set(&mut self.phi, 3 * joint + i, lane, turn[i]);
        }
    }

    /// Momentum of one lane; the spin of a section is that of its directors, which carry its
    /// inertia.
    pub(super) fn momentum(&self, lane: usize) -> Momentum {
        let n = self.chain.n;
        let mut sum = Momentum::default();
        for a in 0..=n {
            let linear = at(&self.chain.model.mass, a, lane) * self.vector(&self.nodes.v, a, lane);
            let angular = self.vector(&self.r, a, lane).cross(&linear);
            sum += Momentum { linear, angular };
        }
        for e in 0..n {
            let frame = self.rotation(e, lane).to_rotation_matrix();
            for k in 0..2 {
                let rate = self.vector(&self.directors.v, 2 * e + k, lane);
                let spin = frame.matrix().column(k).cross(&rate);
                sum.angular += at(&self.chain.model.inertia, 2 * e + k, lane) * spin;
            }
        }
        sum
    }

    /// Elastic energy of joint `j` of one lane, J, where its rotation vector differs by `strain`
    /// (rad) from the natural one.
    pub(super) fn stored(&self, lane: usize, j: usize, strain: &Vector3<f64>) -> f64 {
        let by_law = self.chain.laws.as_ref().and_then(|laws| laws.stored(lane, j, strain));
        by_law.unwrap_or_else(|| {
            let stiffness = self.vector(&self.chain.model.stiffness, j, lane);
            0.5 * strain.dot(&stiffness.component_mul(strain))
        })
    }

    pub(super) fn energy(&self, lane: usize, gravity: &Vector3<f64>) -> Energy {
        let n = self.chain.n;
        let [root, tip] = self.chain.ends.joined(lane);
        let mut energy = Energy::default();
        for a in 0..=n {
            let mass = at(&self.chain.model.mass, a, lane);
            energy.kinetic += 0.5 * mass * self.vector(&self.nodes.v, a, lane).norm_squared();
            energy.gravitational -= mass * gravity.dot(&self.vector(&self.r, a, lane));
            let joined = match a {
                0 => root,
                a if a == n => tip,
                _ => true,
            };
            if joined {
                let strain =
                    self.vector(&self.phi, a, lane) - self.vector(&self.chain.model.rest, a, lane);
                energy.elastic += self.stored(lane, a, &strain);
            }
        }
        for i in 0..2 * n {
            let rate = self.vector(&self.directors.v, i, lane);
            energy.kinetic += 0.5 * at(&self.chain.model.inertia, i, lane) * rate.norm_squared();
        }
        energy
    }
}
