//! Reading the state of one lane of a batch.

use super::array::{at, get};
use super::simd_batch::SimdBatch;
use crate::joint::Joint;
use crate::node_quantity::at_nodes;
use crate::{Energy, Momentum, NodeQuantity, Rod, RodState};
use nalgebra::{Point3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use pulp::bytemuck::Pod;
use pulp::{NullaryFnOnce, Simd};
use rapunzel_lanes::{LANES, Lane, Quat, V3};

/// State and energy of a batch, one lane at a time.
pub(super) trait BatchReadout {
    /// The lane's state; forces are the segment forces at the end of the last step.
    fn state(&self, lane: usize, rod: &Rod, time: f64) -> RodState;
    /// The energies of all lanes in a field of gravity (m/s^2).
    fn energies(&self, gravity: &Vector3<f64>) -> [Energy; LANES];
    /// The lane's momentum; a section spins as its directors, which carry its inertia.
    fn momentum(&self, lane: usize) -> Momentum;
    /// Appends the positions of all nodes of the lane, m, world frame.
    fn node_positions(&self, lane: usize, into: &mut Vec<Point3<f64>>);
    /// Appends the values of a quantity at all nodes of the lane.
    fn node_values(&self, lane: usize, rod: &Rod, of: NodeQuantity, into: &mut Vec<f64>);
    /// Position (m) and velocity (m/s) of a node, world frame.
    fn node(&self, lane: usize, node: usize) -> (Point3<f64>, Vector3<f64>);
    /// How much of the lane's fibre is inside a nozzle, m.
    fn inside_nozzle(&self, lane: usize) -> f64;
    /// Whether root and tip of the lane are clamped.
    fn clamps(&self, lane: usize) -> [bool; 2];
    /// Directors d1 and d2 of a segment of the lane, where a step under way has been solved to,
    /// world frame.
    fn section(&self, lane: usize, segment: usize) -> [Vector3<f64>; 2];
}

impl<S: Simd> BatchReadout for SimdBatch<S> {
    fn state(&self, lane: usize, rod: &Rod, time: f64) -> RodState {
        let n = self.chain.n;
        let frames: Vec<_> = (0..n).map(|e| self.rotation(e, lane).to_rotation_matrix()).collect();
        let mut positions = Vec::with_capacity(n + 1);
        self.node_positions(lane, &mut positions);
        RodState {
            time,
            positions,
            velocities: (0..=n).map(|a| self.vector(&self.nodes.v, a, lane)).collect(),
            angular_velocities: frames
                .iter()
                .enumerate()
                .map(|(e, frame)| frame.inverse_transform_vector(&self.world_spin(e, lane, frame)))
                .collect(),
            frames,
            forces: (0..n).map(|e| self.vector(&self.chain.force, e, lane)).collect(),
            curvatures: self.curvatures(lane, rod).collect(),
        }
    }

    fn node_positions(&self, lane: usize, into: &mut Vec<Point3<f64>>) {
        into.extend(
            (0..=self.chain.n).map(|a| Point3::from(self.vector(&self.chain.start, a, lane))),
        );
    }

    fn node_values(&self, lane: usize, rod: &Rod, of: NodeQuantity, into: &mut Vec<f64>) {
        let n = self.chain.n;
        match of {
            NodeQuantity::Speed => {
                into.extend((0..=n).map(|a| self.vector(&self.nodes.v, a, lane).norm()));
            }
            NodeQuantity::Curvature => {
                into.extend(self.curvatures(lane, rod).map(|kappa| kappa.xy().norm()));
            }
            NodeQuantity::Tension => {
                let of = |e: usize| {
                    let frame = self.rotation(e, lane).to_rotation_matrix();
                    frame.matrix().column(2).dot(&self.vector(&self.chain.force, e, lane))
                };
                into.extend(at_nodes((0..n).map(of)));
            }
        }
    }

    fn energies(&self, gravity: &Vector3<f64>) -> [Energy; LANES] {
        struct EnergyPass<'a, S: Simd>(&'a SimdBatch<S>, &'a Vector3<f64>);
        impl<S: Simd> NullaryFnOnce for EnergyPass<'_, S> {
            type Output = [Energy; LANES];
            #[inline(always)]
            fn call(self) -> [Energy; LANES] {
                self.0.energy_lanes(self.1)
            }
        }
        self.chain.simd.vectorize(EnergyPass(self, gravity))
    }

    fn momentum(&self, lane: usize) -> Momentum {
        let n = self.chain.n;
        let mut sum = Momentum::default();
        for a in 0..=n {
            let linear = at(&self.chain.model.mass, a, lane) * self.vector(&self.nodes.v, a, lane);
            let angular = self.vector(&self.chain.start, a, lane).cross(&linear);
            sum += Momentum { linear, angular };
        }
        for e in 0..n {
            let frame = self.rotation(e, lane).to_rotation_matrix();
            for (k, rate) in self.director_rates(e, lane, &frame).into_iter().enumerate() {
                let spin = frame.matrix().column(k).cross(&rate);
                sum.angular += at(&self.chain.model.inertia, 2 * e + k, lane) * spin;
            }
        }
        sum
    }

    fn node(&self, lane: usize, node: usize) -> (Point3<f64>, Vector3<f64>) {
        (self.vector(&self.chain.start, node, lane).into(), self.vector(&self.nodes.v, node, lane))
    }

    fn inside_nozzle(&self, lane: usize) -> f64 {
        self.inside(lane)
    }

    fn clamps(&self, lane: usize) -> [bool; 2] {
        self.chain.ends.joined(lane)
    }

    fn section(&self, lane: usize, segment: usize) -> [Vector3<f64>; 2] {
        let frame = self.rotation(segment, lane).to_rotation_matrix();
        [0, 1].map(|k| frame.matrix().column(k).into_owned())
    }
}

impl<S: Simd> SimdBatch<S> {
    /// Vector `i` of an array, in one lane.
    pub(super) fn vector(&self, a: &[S::f64s], i: usize, lane: usize) -> Vector3<f64> {
        Vector3::from_fn(|k, _| at(a, 3 * i + k, lane))
    }

    /// Darboux vectors at the nodes of a lane, material frame, 1/m: natural at an end without a
    /// joint.
    fn curvatures(&self, lane: usize, rod: &Rod) -> impl Iterator<Item = Vector3<f64>> {
        let (n, nodes) = (self.chain.n, rod.fiber.nodes());
        let [root, tip] = self.chain.ends.joined(lane);
        (0..=n).map(move |j| {
            if (j == 0 && !root) || (j == n && !tip) {
                return nodes[j].natural_curvature;
            }
            let length = Joint::new(&rod.fiber, j).length / self.stiffening(lane, j);
            nodes[j].natural_curvature + self.strain(lane, j) / length
        })
    }

    pub(super) fn rotation(&self, e: usize, lane: usize) -> UnitQuaternion<f64> {
        quaternion(&self.chain.q, e, lane)
    }

    /// Energies of all lanes in a field of gravity, m/s^2.
    #[inline(always)]
    fn energy_lanes(&self, gravity: &Vector3<f64>) -> [Energy; LANES] {
        let (chain, model) = (&self.chain, &self.chain.model);
        let zero = Lane::splat(chain.simd, 0.0);
        let half = zero.lift(0.5);
        let down = V3([0, 1, 2].map(|i| zero.lift(-gravity[i])));
        let (mut kinetic, mut elastic, mut gravitational) = (zero, zero, zero);
        for a in 0..=chain.n {
            let mass = chain.one(&model.mass, a);
            let v = chain.vec(&self.nodes.v, a);
            kinetic = (mass * half).mul_add(v.dot(v), kinetic);
            gravitational = mass.mul_add(down.dot(chain.vec(&self.chain.start, a)), gravitational);
            if chain.laws.is_none() {
                let joined = match a {
                    0 => Lane::new(chain.simd, chain.ends.root_joint),
                    a if a == chain.n => Lane::new(chain.simd, chain.ends.tip_joint),
                    _ => zero.lift(1.0),
                };
                let one = zero.lift(1.0);
                let stiffening = chain.nozzle.as_ref().map_or(one, |n| chain.one(&n.stiffening, a));
                let rest = chain.vec(&model.rest, a).scale(stiffening.recip());
                let strain = chain.vec(&self.phi, a) - rest;
                let V3(mut moment) = chain.vec(&model.stiffness, a);
                for i in 0..3 {
                    moment[i] = moment[i] * strain.0[i];
                }
                let twice = V3(moment).dot(strain);
                elastic = (joined * stiffening * half).mul_add(twice, elastic);
            }
        }
        for e in 0..chain.n {
            let first = chain.vec(&self.directors.v, 2 * e);
            let second = chain.vec(&self.directors.v, 2 * e + 1);
            let directors = Quat::load(chain.simd, &chain.q, e).directors();
            for k in 0..2 {
                let square = if chain.spins {
                    // Of `director_rates`, whose parts are at right angles.
                    let (aside, spin) = (first.dot(directors[k]), second.0[0]);
                    aside.mul_add(aside, spin * spin)
                } else {
                    let rate = if k == 0 { first } else { second };
                    rate.dot(rate)
                };
                let inertia = chain.one(&model.inertia, 2 * e + k);
                kinetic = (inertia * half).mul_add(square, kinetic);
            }
        }
        let mut energies = [Energy::default(); LANES];
        for (lane, energy) in energies.iter_mut().enumerate().take(S::F64_LANES) {
            *energy = Energy {
                kinetic: get(kinetic, lane),
                elastic: get(elastic, lane),
                gravitational: get(gravitational, lane),
            };
            if chain.laws.is_some() {
                let [root, tip] = chain.ends.joined(lane);
                let joints = usize::from(!root)..chain.n + usize::from(tip);
                energy.elastic = joints.map(|j| self.stored(lane, j, &self.strain(lane, j))).sum();
            }
        }
        energies
    }

    /// Angular velocity of segment `e`, world frame, with its material frame: half the sum of
    /// `d x d'`.
    fn world_spin(&self, e: usize, lane: usize, frame: &Rotation3<f64>) -> Vector3<f64> {
        let h = at(&self.chain.model.h, e, lane);
        let v = |a: usize| self.vector(&self.nodes.v, a, lane);
        let [first, second] = self.director_rates(e, lane, frame);
        let rates = [first, second, (v(e + 1) - v(e)) / h];
        let mut sum = Vector3::zeros();
        for (k, rate) in rates.iter().enumerate() {
            sum += 0.5 * frame.matrix().column(k).cross(rate);
        }
        sum
    }

    /// Velocities of d1 and d2 of segment `e`, 1/s, world frame, with its material frame.
    fn director_rates(&self, e: usize, lane: usize, frame: &Rotation3<f64>) -> [Vector3<f64>; 2] {
        let rates = [2 * e, 2 * e + 1].map(|i| self.vector(&self.directors.v, i, lane));
        if !self.chain.spins {
            return rates;
        }
        // Directors stay at right angles: d1' d3 = -d1 d3', d1' d2 = -d2' d1, the spin rate.
        let [d1, d2, d3] = [0, 1, 2].map(|k| frame.matrix().column(k));
        let (axis, spin) = (rates[0], rates[1].x);
        [d2 * spin - d3 * axis.dot(&d1), -d1 * spin - d3 * axis.dot(&d2)]
    }

    /// By how much the rotation vector of joint `j` of one lane differs from the natural one at the
    /// start of the step, rad.
    pub(super) fn strain(&self, lane: usize, j: usize) -> Vector3<f64> {
        let rest = self.vector(&self.chain.model.rest, j, lane) / self.stiffening(lane, j);
        self.vector(&self.phi, j, lane) - rest
    }

    /// Elastic energy of joint `j` of one lane, J, where its rotation vector differs by `strain`
    /// (rad) from the natural one.
    pub(super) fn stored(&self, lane: usize, j: usize, strain: &Vector3<f64>) -> f64 {
        let by_law = self.chain.laws.as_ref().and_then(|laws| laws.stored(lane, j, strain));
        by_law.unwrap_or_else(|| {
            let stiffness = self.vector(&self.chain.model.stiffness, j, lane);
            0.5 * self.stiffening(lane, j) * strain.dot(&stiffness.component_mul(strain))
        })
    }
}

/// Rotation of segment `e` in an array of unit quaternions, in one lane.
fn quaternion<T: Pod>(all: &[T], e: usize, lane: usize) -> UnitQuaternion<f64> {
    let q = |i: usize| at(all, 4 * e + i, lane);
    UnitQuaternion::new_unchecked(Quaternion::new(q(3), q(0), q(1), q(2)))
}
