//! A pack with its register width hidden, and the choice of that width.

use super::ends::Kind;
use super::lanes::zeros;
use super::pack::{Pack, at, lanes, set};
use super::response::Inertia;
use super::scheme::{Problem, Scheme};
use super::search::Outcome;
use super::track::Track;
use crate::{Energy, Instant, Ledger, Momentum, Point, PointResponses, Rod, RodState};
use nalgebra::{Matrix3, Point3, Vector3};
use pulp::Simd;
use pulp::bytemuck::{self, Zeroable};

/// What a batch needs of a [`Pack`], whatever its register width.
pub(super) trait Engine: Send + Sync {
    fn attempt(
        &mut self,
        dt: &[f64; 8],
        wanted: &[bool; 8],
        problem: Problem,
        out: &mut [Outcome; 8],
    );
    fn set_out(&mut self, wanted: &[bool; 8]);
    fn measure(&mut self, wanted: &[bool; 8]);
    fn commit(&mut self, dt: &[f64; 8], done: &[bool; 8], problem: Problem);
    /// Notes how the ends of a lane are before a step whose ledger is wanted; `known` tells whether
    /// their reactions are those now.
    fn open_ledger(&mut self, lane: usize, now: &Instant, known: bool);
    /// Ledgers of an attempt that is about to be committed in the lanes that are `done`.
    fn account(&mut self, dt: &[f64; 8], done: &[bool; 8]) -> [Ledger; 8];
    fn set_conditions(&mut self, lane: usize, now: &Instant);
    fn set_state(&mut self, lane: usize, rod: &Rod, state: &RodState);
    /// Takes over the laws of the rod, which remember as much as those before.
    fn set_laws(&mut self, lane: usize, rod: &Rod);
    fn set_node_force(&mut self, lane: usize, node: usize, force: &Vector3<f64>);
    fn state(&self, lane: usize, rod: &Rod, time: f64) -> RodState;
    fn energy(&self, lane: usize, gravity: &Vector3<f64>) -> Energy;
    fn momentum(&self, lane: usize) -> Momentum;
    fn node(&self, lane: usize, node: usize) -> (Point3<f64>, Vector3<f64>);
    /// How far the last attempt moves a node.
    fn displacement(&self, lane: usize, node: usize) -> Vector3<f64>;
    /// Appends all numbers of one lane's state.
    fn save(&self, lane: usize, numbers: &mut Vec<f64>);
    /// Takes the numbers back from the front of `numbers`, and returns the rest.
    fn restore<'a>(&mut self, lane: usize, numbers: &'a [f64]) -> &'a [f64];
    /// Takes back the rotations and the reaction of one lane only, which an attempt changes.
    fn undo(&mut self, lane: usize);
    /// Remembers the state of all lanes, for [`Engine::undo`] and [`Engine::undo_all`].
    fn remember(&mut self);
    /// Takes all lanes back to the state that was remembered.
    fn undo_all(&mut self);
    /// Replaces impulses on the nodes, fibre by fibre, by the mean velocities they cause.
    fn respond(&mut self, fibers: usize, impulses: &[Vector3<f64>], out: &mut [Vector3<f64>]);
    fn diagonal_blocks(&mut self, fibers: usize, blocks: &mut [Matrix3<f64>]);
    /// The same for points in any order.
    fn respond_at(
        &mut self,
        points: &[Point],
        impulses: &[Vector3<f64>],
        inertia: Inertia,
        out: &mut [Vector3<f64>],
    );
    /// How points of the same fibre answer impulses on each other, for fibres with any.
    fn write_out(&mut self, points: &[Point]) -> Vec<PointResponses>;
    fn weigh(&mut self, points: &[Point], masses: &[f64]);
    /// Sets the impulses on the nodes of one lane at the start of the step; none acts any more
    /// once a step is set out on anew.
    fn set_impulses(&mut self, lane: usize, impulses: &[Vector3<f64>]);
    /// Sets out on a step of length `dt`, to where the motion leads.
    fn look(&mut self, dt: f64);
    /// Solves Newton's equations where the rods are; returns the largest increments, rad.
    fn linearize(&mut self) -> [f64; 8];
    /// How far a node moves in the step, with what the last linearisation would add.
    fn linear_displacement(&self, lane: usize, node: usize) -> Vector3<f64>;
    /// Takes the increments, with other impulses than those of the linearisation.
    fn advance(&mut self, fibers: usize, impulses: &[Vector3<f64>]) -> [f64; 8];
    /// Takes all motion of one lane away.
    fn stop(&mut self, lane: usize);
    /// How many numbers the state of a lane has.
    fn numbers(&self, lane: usize) -> usize;
}

impl<S: Simd> Engine for Pack<S> {
    fn attempt(
        &mut self,
        dt: &[f64; 8],
        wanted: &[bool; 8],
        problem: Problem,
        out: &mut [Outcome; 8],
    ) {
        Self::attempt(self, dt, wanted, problem, out);
    }
    fn measure(&mut self, wanted: &[bool; 8]) {
        Self::measure(self, wanted);
    }
    fn set_out(&mut self, wanted: &[bool; 8]) {
        Self::set_out(self, wanted);
    }
    fn commit(&mut self, dt: &[f64; 8], done: &[bool; 8], problem: Problem) {
        Self::commit(self, dt, done, problem);
    }
    fn open_ledger(&mut self, lane: usize, now: &Instant, known: bool) {
        Self::open_ledger(self, lane, now, known);
    }
    fn account(&mut self, dt: &[f64; 8], done: &[bool; 8]) -> [Ledger; 8] {
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
        self.vector(&self.chain.r, node, lane) - self.vector(&self.r, node, lane)
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
    fn undo_all(&mut self) {
        let backup = std::mem::replace(&mut self.backup, zeros::<S>(0));
        let mut rest = &backup[..];
        for array in self.arrays_mut() {
            let (head, tail) = rest.split_at(array.len());
            array.copy_from_slice(head);
            rest = tail;
        }
        self.backup = backup;
        self.chain.laws.iter_mut().for_each(|laws| laws.undo_all());
    }
    fn remember(&mut self) {
        let mut backup = std::mem::replace(&mut self.backup, zeros::<S>(0));
        backup.clear();
        for array in self.arrays() {
            backup.extend_from_slice(array);
        }
        self.backup = backup;
        self.chain.laws.iter_mut().for_each(|laws| laws.remember());
        self.impulses.fill(S::f64s::zeroed());
        self.absorbed = [[S::f64s::zeroed(); 3]; 2];
        self.q_start.copy_from_slice(&self.chain.q);
        self.reaction_start = self.chain.ends.tip_reaction;
    }
    fn undo(&mut self, lane: usize) {
        for i in 0..self.q_start.len() {
            set(&mut self.chain.q, i, lane, at(&self.q_start, i, lane));
        }
        for i in 0..3 {
            set(&mut self.chain.ends.tip_reaction, i, lane, at(&self.reaction_start, i, lane));
        }
    }
    fn respond(&mut self, fibers: usize, impulses: &[Vector3<f64>], out: &mut [Vector3<f64>]) {
        let nodes = self.chain.n + 1;
        for (lane, impulses) in impulses.chunks_exact(nodes).enumerate().take(fibers) {
            for (to, from) in lanes(&mut self.work.values).zip(impulses) {
                for i in 0..3 {
                    to[i * S::F64_LANES + lane] = from[i];
                }
            }
        }
        Self::respond(self, Inertia::Own, 0);
        for (lane, out) in out.chunks_exact_mut(nodes).enumerate().take(fibers) {
            for (from, to) in lanes(&mut self.work.values).zip(out) {
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
                let entry = |i: usize| at(&self.work.blocks, 6 * a + i, lane);
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
        let values = bytemuck::cast_slice_mut::<S::f64s, f64>(&mut self.work.values);
        // One node before is looked at too, as the end of the first segment that is solved for.
        values[3 * S::F64_LANES * from.saturating_sub(1)..].fill(0.0);
        for (point, impulse) in points.iter().zip(impulses) {
            let node = &mut values[first::<S>(point)..];
            for i in 0..3 {
                let behind = point.fraction * impulse[i];
                node[i * S::F64_LANES] += impulse[i] - behind;
                node[(3 + i) * S::F64_LANES] += behind;
            }
        }
        Self::respond(self, inertia, from);
        let values = bytemuck::cast_slice::<S::f64s, f64>(&self.work.values);
        for (point, out) in points.iter().zip(out) {
            let node = &values[first::<S>(point)..];
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
            let is_held =
                (a == 0 && held.root != Kind::Loaded) || (a == last && held.tip != Kind::Loaded);
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
    fn linearize(&mut self) -> [f64; 8] {
        Self::linearize(self)
    }
    fn linear_displacement(&self, lane: usize, node: usize) -> Vector3<f64> {
        Engine::displacement(self, lane, node) + self.vector(&self.work.way, node, lane)
    }
    fn advance(&mut self, fibers: usize, impulses: &[Vector3<f64>]) -> [f64; 8] {
        let nodes = self.chain.n + 1;
        self.work.values.fill(S::f64s::zeroed());
        for (lane, impulses) in impulses.chunks_exact(nodes).enumerate().take(fibers) {
            for (a, impulse) in impulses.iter().enumerate() {
                let change = impulse - self.vector(&self.impulses, a, lane);
                for i in 0..3 {
                    set(&mut self.work.values, 3 * a + i, lane, change[i]);
                }
            }
            self.set_impulses(lane, impulses);
        }
        Self::advance(self)
    }
    fn stop(&mut self, lane: usize) {
        let tracks = [&mut self.nodes, &mut self.directors, &mut self.joints];
        for array in tracks.into_iter().flat_map(Track::arrays_mut) {
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

/// Index of the first number of the node before a point, in an array of vectors.
fn first<S: Simd>(point: &Point) -> usize {
    3 * S::F64_LANES * point.segment as usize + point.fiber as usize
}

/// Builds the engine for at most eight rods: two lanes for one or two, else eight. All variants
/// compute the same numbers where the machine has fused multiply-add.
pub(super) fn build(rods: &[Rod], scheme: Scheme) -> Box<dyn Engine> {
    let wide = rods.len() > 2;
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V4::try_new()
        && wide
    {
        return Box::new(Pack::new(simd, rods, scheme));
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return if wide {
            Box::new(Pack::new(pulp::x86::V3_512b(simd), rods, scheme))
        } else {
            Box::new(Pack::new(pulp::x86::V3_128b(simd), rods, scheme))
        };
    }
    if wide {
        Box::new(Pack::new(pulp::Scalar512b, rods, scheme))
    } else {
        Box::new(Pack::new(pulp::Scalar128b, rods, scheme))
    }
}
