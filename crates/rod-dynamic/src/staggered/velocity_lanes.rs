//! Positions and velocities in a step of a batch that is taken in several calls, lane by lane.

use super::array::{at, get};
use super::simd_batch::SimdBatch;
use nalgebra::{Point3, Vector3};
use pulp::{NullaryFnOnce, Simd};
use rapunzel_lanes::{Lane, Quat, V3};

/// Which velocities of a step under way are meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepVelocity {
    /// Velocities at the start of the step, before impulses.
    Start,
    /// Means over the step as it has been solved so far: displacement or rotation over its length.
    /// With backward Euler the rotation is the swing of the axis with any number of turns about
    /// that.
    Mean,
    /// Means over the step if the increments of the last linearisation were taken, to first order.
    Linear,
}

/// What is read of all nodes or segments of a batch.
#[derive(Clone, Copy)]
pub(super) enum Quantity {
    /// Positions of the nodes at the start of the step, m, world.
    Start,
    /// Positions of the nodes where the step has been solved to, m, world.
    End,
    /// Velocities of the nodes, m/s, world.
    Velocity(StepVelocity),
    /// Angular velocities of the segments, rad/s, world.
    Spin(StepVelocity),
}

/// Positions and velocities of all nodes and segments of a batch, into one slice for each lane.
pub(super) trait BatchVelocities {
    /// Writes the positions of all nodes at the start of the step, m, world.
    fn start_positions(&self, positions: &mut [&mut [Point3<f64>]]);
    /// Writes the positions of all nodes where the step has been solved to, m, world.
    fn end_positions(&self, positions: &mut [&mut [Point3<f64>]]);
    /// Writes velocities of all nodes, or of some, in a step of `dt` seconds, m/s, world.
    fn velocities(
        &self,
        which: StepVelocity,
        dt: f64,
        some: Option<&[usize]>,
        velocities: &mut [&mut [Vector3<f64>]],
    );
    /// Writes angular velocities of all segments, or of some, in a step of `dt` seconds, rad/s,
    /// world.
    fn spins(
        &self,
        which: StepVelocity,
        dt: f64,
        some: Option<&[usize]>,
        spins: &mut [&mut [Vector3<f64>]],
    );
    /// Displacement of a node in the step with the increments of the last linearisation, to first
    /// order, m, world.
    fn linear_displacement(&self, lane: usize, node: usize) -> Vector3<f64>;
}

impl<S: Simd> BatchVelocities for SimdBatch<S> {
    fn start_positions(&self, positions: &mut [&mut [Point3<f64>]]) {
        self.read(Quantity::Start, 1.0, None, positions);
    }

    fn end_positions(&self, positions: &mut [&mut [Point3<f64>]]) {
        self.read(Quantity::End, 1.0, None, positions);
    }

    fn velocities(
        &self,
        which: StepVelocity,
        dt: f64,
        some: Option<&[usize]>,
        velocities: &mut [&mut [Vector3<f64>]],
    ) {
        self.read(Quantity::Velocity(which), dt, some, velocities);
        if self.chain.supports.is_some() && which == StepVelocity::Linear {
            for (lane, own) in velocities.iter_mut().enumerate() {
                for a in [0, self.chain.n] {
                    own[a] = self.linear_displacement(lane, a) / dt;
                }
            }
        }
    }

    fn spins(
        &self,
        which: StepVelocity,
        dt: f64,
        some: Option<&[usize]>,
        spins: &mut [&mut [Vector3<f64>]],
    ) {
        self.read(Quantity::Spin(which), dt, some, spins);
    }

    fn linear_displacement(&self, lane: usize, node: usize) -> Vector3<f64> {
        let (kept, n) = (&self.chain.kept, self.chain.n);
        let force = |e: usize| self.vector(&kept.step, 2 * e, lane);
        let mut sum = if node < n { force(node) } else { Vector3::zeros() };
        if node > 0 {
            sum -= force(node - 1);
        }
        if !self.joint_changes.is_empty() {
            sum += self.vector(&self.joint_changes, node, lane);
        }
        let mut added = sum * at(&kept.w, node, lane);
        if let (Some(both), true) = (&self.chain.supports, node == 0 || node == n) {
            added += both[usize::from(node == n)].moved(lane, &sum);
        }
        if node == n {
            added += self.vector(&kept.gap, 0, lane);
        }
        self.vector(&kept.r, node, lane) - self.vector(&self.chain.start, node, lane) + added
    }
}

impl<S: Simd> SimdBatch<S> {
    /// Writes a quantity of every node or segment, or of some, of a step of `dt` seconds.
    fn read<T: From<[f64; 3]>>(
        &self,
        quantity: Quantity,
        dt: f64,
        some: Option<&[usize]>,
        out: &mut [&mut [T]],
    ) {
        struct Read<'a, 'b, S: Simd, T> {
            pack: &'a SimdBatch<S>,
            quantity: Quantity,
            dt: f64,
            some: Option<&'a [usize]>,
            out: &'a mut [&'b mut [T]],
        }
        impl<S: Simd, T: From<[f64; 3]>> Read<'_, '_, S, T> {
            #[inline(always)]
            fn one(&mut self, i: usize, rate: Lane<S>) {
                let pack = self.pack;
                let V3(read) = match self.quantity {
                    Quantity::Start => pack.chain.vec(&pack.chain.start, i),
                    Quantity::End => pack.chain.vec(&pack.chain.kept.r, i),
                    Quantity::Velocity(which) => pack.node_velocity(which, i, rate),
                    Quantity::Spin(which) => pack.segment_spin(which, i, rate),
                };
                for (lane, own) in self.out.iter_mut().enumerate() {
                    own[i] = [get(read[0], lane), get(read[1], lane), get(read[2], lane)].into();
                }
            }
        }
        impl<S: Simd, T: From<[f64; 3]>> NullaryFnOnce for Read<'_, '_, S, T> {
            type Output = ();
            #[inline(always)]
            fn call(mut self) {
                let rate = Lane::splat(self.pack.chain.simd, self.dt.recip());
                // Closures would not be compiled for these registers.
                if let Some(some) = self.some {
                    for &i in some {
                        self.one(i, rate);
                    }
                } else {
                    for i in 0..self.out.first().map_or(0, |own| own.len()) {
                        self.one(i, rate);
                    }
                }
            }
        }
        self.chain.simd.vectorize(Read { pack: self, quantity, dt, some, out });
    }

    /// Velocity of node `a` in a step, by what is 1 over its length; at supported ends without what
    /// their mobility adds to linear ones.
    #[inline(always)]
    fn node_velocity(&self, which: StepVelocity, a: usize, rate: Lane<S>) -> V3<S> {
        let chain = &self.chain;
        if which == StepVelocity::Start {
            return chain.vec(&self.nodes.v, a);
        }
        let mut way = chain.vec(&chain.kept.r, a) - chain.vec(&self.chain.start, a);
        if which == StepVelocity::Linear {
            // The forces beside the node move it by their change.
            let w = chain.one(&chain.kept.w, a);
            if a < chain.n {
                way = chain.vec(&chain.kept.step, 2 * a).mul_add(w, way);
            }
            if a > 0 {
                way -= chain.vec(&chain.kept.step, 2 * (a - 1)).scale(w);
            }
            if a == chain.n {
                way += chain.vec(&chain.kept.gap, 0);
            }
        }
        way.scale(rate)
    }

    /// Angular velocity of segment `e` in a step, by what is 1 over its length.
    #[inline(always)]
    fn segment_spin(&self, which: StepVelocity, e: usize, rate: Lane<S>) -> V3<S> {
        match which {
            StepVelocity::Start => self.start_spin(e),
            StepVelocity::Mean => self.step_rotation(e).scale(rate),
            StepVelocity::Linear => {
                let added = self.chain.vec(&self.chain.kept.step, 2 * e + 1);
                (self.step_rotation(e) + added).scale(rate)
            }
        }
    }

    /// Angular velocity of segment `e` at the start of the step, rad/s, world: half the sum of
    /// `d x d'`.
    #[inline(always)]
    fn start_spin(&self, e: usize) -> V3<S> {
        let chain = &self.chain;
        let d = Quat::load(chain.simd, &self.before.q, e).directors();
        let v = |a: usize| chain.vec(&self.nodes.v, a);
        let axis = (v(e + 1) - v(e)).scale(chain.one(&chain.model.h, e).recip());
        let first = chain.vec(&self.directors.v, 2 * e);
        let second = chain.vec(&self.directors.v, 2 * e + 1);
        let half = axis.0[0].lift(0.5);
        if chain.spins {
            // The rates of d3 and of the spin.
            return d[2].mul_add(second.0[0], d[2].cross(first + axis).scale(half));
        }
        (d[0].cross(first) + d[1].cross(second) + d[2].cross(axis)).scale(half)
    }
}
