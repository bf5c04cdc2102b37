//! Response matrices of a few points.

use super::array::{at, set};
use super::response::ImpulseColumns;
use super::simd_batch::SimdBatch;
use crate::{Point, PointResponses};
use nalgebra::DMatrix;
use pulp::Simd;
use pulp::bytemuck::Zeroable;

impl<S: Simd> SimdBatch<S> {
    /// Response matrices of the points of every fibre that has any. One solve for the first points
    /// of all fibres, one for the second points, and so on.
    pub(super) fn write_out(&mut self, points: &[Point]) -> Vec<PointResponses> {
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
        let mut columns = ImpulseColumns::<S>::new(self.chain.n);
        let most = all.iter().map(|one| one.points.len()).max().unwrap_or(0);
        for turn in 0..most {
            let now = || all.iter().filter_map(|one| one.points.get(turn));
            let from = now().map(|&i| points[i].segment as usize).min().unwrap_or(0);
            // The node before is read too, as the end of the first segment that is solved for.
            columns.values[9 * from.saturating_sub(1)..].fill(S::f64s::zeroed());
            // Unit impulses along x, y and z at the present point of each fibre.
            for &i in now() {
                let Point { fiber, segment, fraction } = points[i];
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
                    let Point { segment, fraction, .. } = points[one.points[row]];
                    let value = |i: usize| at(&columns.values, 9 * segment as usize + i, lane);
                    for k in 0..3 {
                        for i in 0..3 {
                            let (before, behind) = (value(3 * k + i), value(9 + 3 * k + i));
                            let answer = before + fraction * (behind - before);
                            one.matrix[(3 * row + i, 3 * turn + k)] = answer;
                            one.matrix[(3 * turn + k, 3 * row + i)] = answer;
                        }
                    }
                }
            }
        }
        all.retain(|one| !one.points.is_empty());
        all
    }
}
