//! Impulses and responses of the rods, converted between vectors of nodes or points and SIMD lanes.

use super::array::{at, lanes, set};
use super::point_places::{both_nodes, segment};
use super::response::{Inertia, Question};
use super::simd_batch::SimdBatch;
use crate::{Point, PointAction, PointResponses};
use nalgebra::{DMatrix, Matrix3, Vector3};
use pulp::Simd;
use pulp::bytemuck::{self, Zeroable};

/// Mean velocities (m/s, world frame) that impulses (N s) at the start of the step cause, to first
/// order about the last solve.
pub(super) trait BatchResponse {
    /// Velocities of all nodes for impulses on them, fibre by fibre.
    fn respond(&mut self, fibers: usize, impulses: &[Vector3<f64>], out: &mut [Vector3<f64>]);
    /// 3 x 3 response of every node to an impulse on itself, 1/kg, and of every segment to a moment
    /// on itself, 1/(kg m^2), fibre by fibre.
    fn diagonal_blocks(
        &mut self,
        fibers: usize,
        nodes: &mut [Matrix3<f64>],
        segments: &mut [Matrix3<f64>],
    );
    /// Velocities of points for impulses on them, in any order.
    fn respond_at(
        &mut self,
        points: &[Point],
        impulses: &[Vector3<f64>],
        inertia: Inertia,
        out: &mut [Vector3<f64>],
    );
    /// Dense response matrices of the points of each fibre that has any. Solves for the first
    /// points of all fibres at once, then for the second ones, and so on.
    fn write_out(&mut self, points: &[Point]) -> Vec<PointResponses>;
    /// Factorises again with masses (kg) added at points, for [`Inertia::Weighted`].
    fn weigh(&mut self, points: &[Point], masses: &[f64]);
}

impl<S: Simd> BatchResponse for SimdBatch<S> {
    fn respond(&mut self, fibers: usize, impulses: &[Vector3<f64>], out: &mut [Vector3<f64>]) {
        let nodes = self.chain.n + 1;
        for (lane, impulses) in impulses.chunks_exact(nodes).enumerate().take(fibers) {
            for (to, from) in lanes(&mut self.chain.room.values).zip(impulses) {
                for i in 0..3 {
                    to[i * S::F64_LANES + lane] = from[i];
                }
            }
        }
        self.chain.room.turns.fill(S::f64s::zeroed());
        self.ask(Question::Respond(Inertia::Own, 0));
        for (lane, out) in out.chunks_exact_mut(nodes).enumerate().take(fibers) {
            for (from, to) in lanes(&mut self.chain.room.values).zip(out) {
                for i in 0..3 {
                    to[i] = from[i * S::F64_LANES + lane];
                }
            }
        }
    }

    fn diagonal_blocks(
        &mut self,
        fibers: usize,
        nodes: &mut [Matrix3<f64>],
        segments: &mut [Matrix3<f64>],
    ) {
        self.ask(Question::Blocks);
        let (n, room) = (self.chain.n, &self.chain.room);
        let parts = [(nodes, n + 1, &room.blocks), (segments, n, &room.turn_blocks)];
        for (blocks, count, array) in parts {
            for (lane, blocks) in blocks.chunks_exact_mut(count).enumerate().take(fibers) {
                for (a, block) in blocks.iter_mut().enumerate() {
                    let entry = |i: usize| at(array, 6 * a + i, lane);
                    let (xy, xz, yz) = (entry(3), entry(4), entry(5));
                    *block = Matrix3::new(entry(0), xy, xz, xy, entry(1), yz, xz, yz, entry(2));
                }
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
        let turns = bytemuck::cast_slice_mut::<S::f64s, f64>(&mut self.chain.room.turns);
        turns[3 * S::F64_LANES * from.saturating_sub(1)..].fill(0.0);
        for (point, impulse) in points.iter().zip(impulses) {
            let (turn, moment) = (&mut turns[segment::<S>(point)], point.moment(impulse));
            for i in 0..3 {
                turn[i * S::F64_LANES] += moment[i];
            }
            let PointAction::Force { fraction, .. } = point.action else { continue };
            let node = &mut values[both_nodes::<S>(point)];
            for i in 0..3 {
                let behind = fraction * impulse[i];
                node[i * S::F64_LANES] += impulse[i] - behind;
                node[(3 + i) * S::F64_LANES] += behind;
            }
        }
        self.ask(Question::Respond(inertia, from));
        let values = bytemuck::cast_slice::<S::f64s, f64>(&self.chain.room.values);
        let turns = bytemuck::cast_slice::<S::f64s, f64>(&self.chain.room.turns);
        for (point, out) in points.iter().zip(out) {
            let (node, turn) = (&values[both_nodes::<S>(point)], &turns[segment::<S>(point)]);
            *out = match point.action {
                PointAction::Force { fraction, .. } => Vector3::from_fn(|i, _| {
                    let (before, behind) = (node[i * S::F64_LANES], node[(3 + i) * S::F64_LANES]);
                    before + fraction * (behind - before)
                }),
                PointAction::Couple { .. } => Vector3::zeros(),
            };
            *out += point.turned(&Vector3::from_fn(|i, _| turn[i * S::F64_LANES]));
        }
    }

    fn write_out(&mut self, points: &[Point]) -> Vec<PointResponses> {
        // Indices of the points of each fibre, from root to tip.
        let mut fibers: Vec<Vec<usize>> = vec![Vec::new(); S::F64_LANES];
        for (i, point) in points.iter().enumerate() {
            fibers[point.fiber as usize].push(i);
        }
        for own in &mut fibers {
            own.sort_by_key(|&i| points[i].segment);
        }
        let mut all: Vec<_> = fibers
            .into_iter()
            .map(|points| {
                let matrix = DMatrix::zeros(3 * points.len(), 3 * points.len());
                PointResponses { points, matrix }
            })
            .collect();
        let mut columns = self.borrow_columns();
        let most = all.iter().map(|one| one.points.len()).max().unwrap_or(0);
        for turn in 0..most {
            let now = || all.iter().filter_map(|one| one.points.get(turn));
            let from = now().map(|&i| points[i].segment as usize).min().unwrap_or(0);
            // The node before is read too, as the end of the first segment that is solved for.
            columns.values[9 * from.saturating_sub(1)..].fill(S::f64s::zeroed());
            columns.turns[9 * from.saturating_sub(1)..].fill(S::f64s::zeroed());
            // Unit impulses along x, y and z at the present point of each fibre, with their
            // moments.
            for &i in now() {
                let Point { fiber, segment, action } = points[i];
                for k in 0..3 {
                    let moment = points[i].moment(&Vector3::ith(k, 1.0));
                    for i in 0..3 {
                        let at = 9 * segment as usize + 3 * k + i;
                        set(&mut columns.turns, at, fiber as usize, moment[i]);
                    }
                }
                let PointAction::Force { fraction, .. } = action else { continue };
                for (node, share) in [(0, 1.0 - fraction), (1, fraction)] {
                    let first = 9 * (segment as usize + node);
                    for k in 0..3 {
                        set(&mut columns.values, first + 4 * k, fiber as usize, share);
                    }
                }
            }
            self.respond_thrice(from, &mut columns);
            // Columns of this point in the rows of the points behind it; the rest follows by
            // symmetry.
            for (lane, one) in all.iter_mut().enumerate() {
                for row in turn..one.points.len() {
                    let point = &points[one.points[row]];
                    let first = 9 * point.segment as usize;
                    let value = |i: usize| at(&columns.values, first + i, lane);
                    for k in 0..3 {
                        let spin = |i: usize, _| at(&columns.turns, first + 3 * k + i, lane);
                        let beside = point.turned(&Vector3::from_fn(spin));
                        for i in 0..3 {
                            let along = match point.action {
                                PointAction::Force { fraction, .. } => {
                                    let (before, behind) = (value(3 * k + i), value(9 + 3 * k + i));
                                    before + fraction * (behind - before)
                                }
                                PointAction::Couple { .. } => 0.0,
                            };
                            let answer = along + beside[i];
                            one.matrix[(3 * row + i, 3 * turn + k)] = answer;
                            one.matrix[(3 * turn + k, 3 * row + i)] = answer;
                        }
                    }
                }
            }
        }
        self.chain.room.columns = columns;
        all.retain(|one| !one.points.is_empty());
        all
    }

    fn weigh(&mut self, points: &[Point], masses: &[f64]) {
        self.ask(Question::Weigh(points, masses));
    }
}
