//! A SIMD batch with its register width hidden, and the choice of that width.

use super::array::{at, lanes, set, zeros};
use super::chain::RotationChain;
use super::ends::EndKind;
use super::history::KinematicHistory;
use super::response::Inertia;
use super::scheme::{Scheme, StepProblem};
use super::search::SearchOutcome;
use super::simd_batch::SimdBatch;
use super::{array, workspace};
use crate::{Energy, Instant, Ledger, Momentum, Point, PointResponses, Rod, RodState};
use nalgebra::{Matrix3, Point3, Vector3};
use pulp::Simd;
use pulp::bytemuck::{self, Zeroable};
use rapunzel_lanes::LANES;
use std::ops::RangeInclusive;

/// Interface of a [`SimdBatch`] of any register width.
pub(super) trait ErasedBatch: Send + Sync {
    /// Borrows the workspace, without which only the state can be read and set.
    fn enter(&mut self);
    /// Returns the borrowed workspace.
    fn leave(&mut self);
    /// Lets the batch own the storage that a step needs from call to call, from now on. Not to be
    /// called between [`ErasedBatch::enter`] and [`ErasedBatch::leave`].
    fn keep(&mut self);
    /// Recomputes the shape that the last call of a step has reached.
    fn arrive(&mut self);
    fn attempt(
        &mut self,
        dt: &[f64; LANES],
        wanted: &[bool; LANES],
        problem: StepProblem,
        out: &mut [SearchOutcome; LANES],
    );
    fn set_out(&mut self, wanted: &[bool; LANES]);
    fn measure(&mut self, wanted: &[bool; LANES]);
    fn commit(&mut self, dt: &[f64; LANES], done: &[bool; LANES], problem: StepProblem);
    /// Records the ends of a lane before a step whose ledger is wanted; `known` tells whether their
    /// reactions are those now.
    fn open_ledger(&mut self, lane: usize, now: &Instant, known: bool);
    /// Ledgers of an attempt that is about to be committed in the lanes that are `done`.
    fn account(&mut self, dt: &[f64; LANES], done: &[bool; LANES]) -> [Ledger; LANES];
    fn set_conditions(&mut self, lane: usize, now: &Instant);
    fn set_state(&mut self, lane: usize, rod: &Rod, state: &RodState);
    /// Replaces the section laws of a lane by those of `rod`, which must have as much memory.
    fn set_laws(&mut self, lane: usize, rod: &Rod);
    fn set_node_force(&mut self, lane: usize, node: usize, force: &Vector3<f64>);
    fn state(&self, lane: usize, rod: &Rod, time: f64) -> RodState;
    fn energy(&self, lane: usize, gravity: &Vector3<f64>) -> Energy;
    fn momentum(&self, lane: usize) -> Momentum;
    fn node(&self, lane: usize, node: usize) -> (Point3<f64>, Vector3<f64>);
    /// Displacement of a node in the last attempt, m, world.
    fn displacement(&self, lane: usize, node: usize) -> Vector3<f64>;
    /// Appends all numbers of one lane's state.
    fn save(&self, lane: usize, numbers: &mut Vec<f64>);
    /// Restores the state of one lane from the front of `numbers`, and returns the rest.
    fn restore<'a>(&mut self, lane: usize, numbers: &'a [f64]) -> &'a [f64];
    /// Restores only the rotations and the tip reaction of one lane, which an attempt changes.
    fn undo(&mut self, lane: usize);
    /// Saves the state that attempts change, for [`ErasedBatch::undo`] and
    /// [`ErasedBatch::undo_all`].
    fn remember(&mut self);
    /// Restores the state of all lanes that was saved, as long as no step has been committed, and
    /// removes the accelerations of lanes that were `fresh`.
    fn undo_all(&mut self, fresh: &[bool; LANES]);
    /// Writes the mean velocities of all nodes, fibre by fibre, that impulses on them cause.
    fn respond(&mut self, fibers: usize, impulses: &[Vector3<f64>], out: &mut [Vector3<f64>]);
    fn diagonal_blocks(&mut self, fibers: usize, blocks: &mut [Matrix3<f64>]);
    /// Writes the mean velocities of points, in any order, that impulses on them cause.
    fn respond_at(
        &mut self,
        points: &[Point],
        impulses: &[Vector3<f64>],
        inertia: Inertia,
        out: &mut [Vector3<f64>],
    );
    /// Response matrices of the points of each fibre, for fibres with any.
    fn write_out(&mut self, points: &[Point]) -> Vec<PointResponses>;
    fn weigh(&mut self, points: &[Point], masses: &[f64]);
    /// Sets the impulses on the nodes of one lane at the start of the step; starting a new step
    /// clears them.
    fn set_impulses(&mut self, lane: usize, impulses: &[Vector3<f64>]);
    /// Starts a step of `dt` seconds at the predicted shape, without solving it.
    fn look(&mut self, dt: f64);
    /// Solves Newton's equations at the present shape; returns the largest increment of each lane,
    /// rad.
    fn linearize(&mut self) -> [f64; LANES];
    /// Displacement of a node in the step with the increments of the last linearisation, m, world.
    fn linear_displacement(&self, lane: usize, node: usize) -> Vector3<f64>;
    /// Takes the increments of the last linearisation, with other impulses than it had; returns the
    /// largest increment of each lane, rad.
    fn advance(&mut self, fibers: usize, impulses: &[Vector3<f64>]) -> [f64; LANES];
    /// Sets all rates of one lane to zero.
    fn stop(&mut self, lane: usize);
    /// Number of scalars in the state of a lane.
    fn numbers(&self, lane: usize) -> usize;
}

impl<S: Simd> ErasedBatch for SimdBatch<S> {
    fn enter(&mut self) {
        if self.borrowed.is_none() {
            let mut room = workspace::borrow(self.chain.n);
            std::mem::swap(&mut self.chain.room, &mut room);
            self.exchange_kept();
            self.borrowed = Some(room);
        }
    }
    fn leave(&mut self) {
        if let Some(mut room) = self.borrowed.take() {
            self.exchange_kept();
            std::mem::swap(&mut self.chain.room, &mut room);
            workspace::give_back(room);
        }
    }
    fn keep(&mut self) {
        self.keeps = true;
        self.chain.kept.fit(self.chain.n);
        array::fit::<S>(&mut self.impulses, 3 * (self.chain.n + 1));
    }
    fn arrive(&mut self) {
        Self::arrive(self);
    }
    fn attempt(
        &mut self,
        dt: &[f64; LANES],
        wanted: &[bool; LANES],
        problem: StepProblem,
        out: &mut [SearchOutcome; LANES],
    ) {
        Self::attempt(self, dt, wanted, problem, out);
    }
    fn measure(&mut self, wanted: &[bool; LANES]) {
        Self::measure(self, wanted);
    }
    fn set_out(&mut self, wanted: &[bool; LANES]) {
        Self::set_out(self, wanted);
    }
    fn commit(&mut self, dt: &[f64; LANES], done: &[bool; LANES], problem: StepProblem) {
        Self::commit(self, dt, done, problem);
    }
    fn open_ledger(&mut self, lane: usize, now: &Instant, known: bool) {
        Self::open_ledger(self, lane, now, known);
    }
    fn account(&mut self, dt: &[f64; LANES], done: &[bool; LANES]) -> [Ledger; LANES] {
        Self::account(self, dt, done)
    }
    fn set_conditions(&mut self, lane: usize, now: &Instant) {
        Self::set_conditions(self, lane, now);
    }
    fn set_state(&mut self, lane: usize, rod: &Rod, state: &RodState) {
        Self::set_state(self, lane, rod, state);
    }
    fn set_laws(&mut self, lane: usize, rod: &Rod) {
        self.chain.laws.iter_mut().for_each(|laws| laws.replace(lane, rod));
    }
    fn set_node_force(&mut self, lane: usize, node: usize, force: &Vector3<f64>) {
        array::fit::<S>(&mut self.node_forces, 3 * (self.chain.n + 1));
        for i in 0..3 {
            set(&mut self.node_forces, 3 * node + i, lane, force[i]);
        }
    }
    fn state(&self, lane: usize, rod: &Rod, time: f64) -> RodState {
        Self::state(self, lane, rod, time)
    }
    fn energy(&self, lane: usize, gravity: &Vector3<f64>) -> Energy {
        Self::energy(self, lane, gravity)
    }
    fn momentum(&self, lane: usize) -> Momentum {
        Self::momentum(self, lane)
    }
    fn node(&self, lane: usize, node: usize) -> (Point3<f64>, Vector3<f64>) {
        (self.vector(&self.r, node, lane).into(), self.vector(&self.nodes.v, node, lane))
    }
    fn displacement(&self, lane: usize, node: usize) -> Vector3<f64> {
        self.vector(&self.chain.kept.r, node, lane) - self.vector(&self.r, node, lane)
    }
    fn save(&self, lane: usize, numbers: &mut Vec<f64>) {
        for array in self.arrays() {
            numbers.extend((0..array.len()).map(|i| at(array, i, lane)));
        }
        self.chain.laws.iter().for_each(|laws| laws.save(lane, numbers));
    }
    fn restore<'a>(&mut self, lane: usize, mut numbers: &'a [f64]) -> &'a [f64] {
        for array in self.arrays_mut() {
            let (head, tail) = numbers.split_at(array.len());
            for (i, x) in head.iter().enumerate() {
                set(array, i, lane, *x);
            }
            numbers = tail;
        }
        self.chain.laws.iter_mut().fold(numbers, |numbers, laws| laws.restore(lane, numbers))
    }
    fn undo_all(&mut self, fresh: &[bool; LANES]) {
        self.chain.q.copy_from_slice(&self.before.q);
        self.chain.force.copy_from_slice(&self.before.force);
        self.chain.ends.put_back(&self.before.ends);
        if !self.before.phi.is_empty() {
            self.phi.copy_from_slice(&self.before.phi);
        }
        for lane in (0..S::F64_LANES).filter(|&lane| fresh[lane]) {
            let tracks = [&mut self.nodes, &mut self.directors, &mut self.joints];
            tracks.into_iter().for_each(|track| track.forget(lane));
        }
        self.chain.laws.iter_mut().for_each(|laws| laws.undo_all());
    }
    fn remember(&mut self) {
        self.before.q.copy_from_slice(&self.chain.q);
        self.before.force.copy_from_slice(&self.chain.force);
        self.before.phi = zeros::<S>(0);
        self.before.ends = self.chain.ends;
        self.chain.laws.iter_mut().for_each(|laws| laws.remember());
        self.impulses.fill(S::f64s::zeroed());
        self.absorbed = [[S::f64s::zeroed(); 3]; 2];
        self.weighted.take_if(|weighted| !std::mem::take(&mut weighted.used));
    }
    fn undo(&mut self, lane: usize) {
        for i in 0..self.before.q.len() {
            set(&mut self.chain.q, i, lane, at(&self.before.q, i, lane));
        }
        for i in 0..3 {
            let reaction = at(&self.before.ends.tip_reaction, i, lane);
            set(&mut self.chain.ends.tip_reaction, i, lane, reaction);
        }
    }
    fn respond(&mut self, fibers: usize, impulses: &[Vector3<f64>], out: &mut [Vector3<f64>]) {
        let nodes = self.chain.n + 1;
        for (lane, impulses) in impulses.chunks_exact(nodes).enumerate().take(fibers) {
            for (to, from) in lanes(&mut self.chain.room.values).zip(impulses) {
                for i in 0..3 {
                    to[i * S::F64_LANES + lane] = from[i];
                }
            }
        }
        Self::respond(self, Inertia::Own, 0);
        for (lane, out) in out.chunks_exact_mut(nodes).enumerate().take(fibers) {
            for (from, to) in lanes(&mut self.chain.room.values).zip(out) {
                for i in 0..3 {
                    to[i] = from[i * S::F64_LANES + lane];
                }
            }
        }
    }
    fn diagonal_blocks(&mut self, fibers: usize, blocks: &mut [Matrix3<f64>]) {
        Self::response_blocks(self);
        let nodes = self.chain.n + 1;
        for (lane, blocks) in blocks.chunks_exact_mut(nodes).enumerate().take(fibers) {
            for (a, block) in blocks.iter_mut().enumerate() {
                let entry = |i: usize| at(&self.chain.room.blocks, 6 * a + i, lane);
                let (xy, xz, yz) = (entry(3), entry(4), entry(5));
                *block = Matrix3::new(entry(0), xy, xz, xy, entry(1), yz, xz, yz, entry(2));
            }
        }
    }
    fn respond_at(
        &mut self,
        points: &[Point],
        impulses: &[Vector3<f64>],
        inertia: Inertia,
        out: &mut [Vector3<f64>],
    ) {
        let Some(from) = points.iter().map(|point| point.segment as usize).min() else { return };
        let values = bytemuck::cast_slice_mut::<S::f64s, f64>(&mut self.chain.room.values);
        // The node before is read too, as the end of the first segment that is solved for.
        values[3 * S::F64_LANES * from.saturating_sub(1)..].fill(0.0);
        for (point, impulse) in points.iter().zip(impulses) {
            let node = &mut values[both_nodes::<S>(point)];
            for i in 0..3 {
                let behind = point.fraction * impulse[i];
                node[i * S::F64_LANES] += impulse[i] - behind;
                node[(3 + i) * S::F64_LANES] += behind;
            }
        }
        Self::respond(self, inertia, from);
        let values = bytemuck::cast_slice::<S::f64s, f64>(&self.chain.room.values);
        for (point, out) in points.iter().zip(out) {
            let node = &values[both_nodes::<S>(point)];
            for i in 0..3 {
                let (before, behind) = (node[i * S::F64_LANES], node[(3 + i) * S::F64_LANES]);
                out[i] = before + point.fraction * (behind - before);
            }
        }
    }
    fn write_out(&mut self, points: &[Point]) -> Vec<PointResponses> {
        Self::write_out(self, points)
    }
    fn weigh(&mut self, points: &[Point], masses: &[f64]) {
        Self::weigh(self, points, masses);
    }
    fn set_impulses(&mut self, lane: usize, impulses: &[Vector3<f64>]) {
        let held = self.held[lane];
        let (last, free) = (impulses.len() - 1, Vector3::zeros());
        for (a, impulse) in impulses.iter().enumerate() {
            let is_held = (a == 0 && held.root != EndKind::Loaded)
                || (a == last && held.tip != EndKind::Loaded);
            let (impulse, absorbed) = if is_held { (&free, impulse) } else { (impulse, &free) };
            for i in 0..3 {
                set(&mut self.impulses, 3 * a + i, lane, impulse[i]);
                if a == 0 || a == last {
                    set(&mut self.absorbed[usize::from(a == last)], i, lane, absorbed[i]);
                }
            }
        }
    }
    fn look(&mut self, dt: f64) {
        Self::look(self, dt);
    }
    fn linearize(&mut self) -> [f64; LANES] {
        Self::linearize(self)
    }
    fn linear_displacement(&self, lane: usize, node: usize) -> Vector3<f64> {
        let (kept, n) = (&self.chain.kept, self.chain.n);
        let force = |e: usize| self.vector(&kept.step, 2 * e, lane);
        let mut sum = if node < n { force(node) } else { Vector3::zeros() };
        if node > 0 {
            sum -= force(node - 1);
        }
        let mut added = sum * at(&kept.w, node, lane);
        if node == n {
            added += self.vector(&kept.gap, 0, lane);
        }
        ErasedBatch::displacement(self, lane, node) + added
    }
    fn advance(&mut self, fibers: usize, impulses: &[Vector3<f64>]) -> [f64; LANES] {
        let nodes = self.chain.n + 1;
        self.chain.room.values.fill(S::f64s::zeroed());
        for (lane, impulses) in impulses.chunks_exact(nodes).enumerate().take(fibers) {
            for (a, impulse) in impulses.iter().enumerate() {
                let change = impulse - self.vector(&self.impulses, a, lane);
                for i in 0..3 {
                    set(&mut self.chain.room.values, 3 * a + i, lane, change[i]);
                }
            }
            self.set_impulses(lane, impulses);
        }
        Self::advance(self)
    }
    fn stop(&mut self, lane: usize) {
        let tracks = [&mut self.nodes, &mut self.directors, &mut self.joints];
        for array in tracks.into_iter().flat_map(KinematicHistory::arrays_mut) {
            for i in 0..array.len() {
                set(array, i, lane, 0.0);
            }
        }
    }
    fn numbers(&self, lane: usize) -> usize {
        let own: usize = self.arrays().iter().map(|a| a.len()).sum();
        own + self.chain.laws.as_ref().map_or(0, |laws| laws.numbers(lane))
    }
}

impl<S: Simd> SimdBatch<S> {
    /// Exchanges the storage that a step needs from call to call with that of the workspace, unless
    /// the batch owns it.
    fn exchange_kept(&mut self) {
        if !self.keeps {
            let RotationChain { room, kept, .. } = &mut self.chain;
            std::mem::swap(kept, &mut room.kept);
        }
    }
}

/// Index range, in an array of vectors, from the first number of the node before a point to the
/// last number of the node behind it.
fn both_nodes<S: Simd>(point: &Point) -> RangeInclusive<usize> {
    let first = 3 * S::F64_LANES * point.segment as usize + point.fiber as usize;
    first..=first + 5 * S::F64_LANES
}

/// Builds the engine for at most eight rods: two lanes for one or two, else eight. All variants
/// compute the same numbers where the machine has fused multiply-add.
pub(super) fn build(rods: &[Rod], scheme: Scheme) -> Box<dyn ErasedBatch> {
    let wide = rods.len() > 2;
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V4::try_new()
        && wide
    {
        return Box::new(SimdBatch::new(simd, rods, scheme));
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return if wide {
            Box::new(SimdBatch::new(pulp::x86::V3_512b(simd), rods, scheme))
        } else {
            Box::new(SimdBatch::new(pulp::x86::V3_128b(simd), rods, scheme))
        };
    }
    if wide {
        Box::new(SimdBatch::new(pulp::Scalar512b, rods, scheme))
    } else {
        Box::new(SimdBatch::new(pulp::Scalar128b, rods, scheme))
    }
}
