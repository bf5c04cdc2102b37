//! The direct sum over pairs of points in single precision.
//!
//! Each coordinate is a sum of two numbers, the second as small as the rounding of the first, so
//! that points that are close to each other are at the right distance.

use super::tree::Cell;
use crate::direct_sum::Cloud;
use pulp::Simd;
use rapunzel_lanes::{Kernel, LANES_F32, Lane, Roots, dispatch};
use std::ops::Range;

/// Number of sources whose sum is made before it is added to the total, so that few roundings add
/// up.
const SOURCES_PER_SUM: usize = 64;

/// Distance, in units of a cell, below which coordinates of single precision are too coarse: of two
/// points that are this close to each other, and one of which is in the cell, each errs by at most
/// 1e-7, and their field by 4e-5 of it.
const CLOSE: f32 = 1e-2;

/// Pairs of which the sums are wanted.
pub(crate) struct SinglePairs<'a> {
    pub(crate) sources: &'a Cloud,
    /// Ranges of the sources.
    pub(crate) ranges: &'a [Range<usize>],
    /// Coordinates of all targets (world, m), of which those of the `cell` are wanted.
    pub(crate) places: &'a [Vec<f64>; 3],
    pub(crate) cell: &'a Cell,
    /// The sources that are the targets themselves.
    pub(crate) own: Range<usize>,
    /// Lengths are divided by the larger of the radius of the cell and this, m, which keeps all
    /// powers of distances within range.
    pub(crate) least: f64,
    /// Whether each pair is to be found to some 1e-6, else to 4e-5, with coordinates that are
    /// rounded to single precision where no pair is close.
    pub(crate) fine: bool,
    /// Sums of the targets of the cell.
    pub(crate) out: &'a mut [[f64; 4]],
}

impl SinglePairs<'_> {
    /// Adds to the sums the potential (1/m) and the negative field (1/m^2) that the sources make at
    /// each target, for their charges.
    ///
    /// Cost: 0.2 ns a pair with AVX-512.
    pub(crate) fn add(self) {
        dispatch(self);
    }
}

/// Source: coordinates in the frame of the cell, what their rounding leaves, and half of the
/// charge.
#[derive(Clone, Copy)]
struct SplitPoint {
    x: [f32; 3],
    rest: [f32; 3],
    charge: f32,
}

/// Frame of a cell: coordinates from its center, in units of a length.
struct CellFrame {
    /// Center (world), m.
    center: [f64; 3],
    /// Inverse of the unit of length, 1/m.
    inverse: f64,
}

impl CellFrame {
    /// Point `k` of `places` (world, m), with half of its charge.
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "rounding is meant; charges are about one")]
    fn point(&self, places: &[Vec<f64>; 3], charge: f64, k: usize) -> SplitPoint {
        let [mut x, mut rest] = [[0.0; 3]; 2];
        for d in 0..3 {
            let exact = (places[d][k] - self.center[d]) * self.inverse;
            x[d] = exact as f32;
            rest[d] = (exact - f64::from(x[d])) as f32;
        }
        SplitPoint { x, rest, charge: 0.5 * charge as f32 }
    }
}

impl Kernel for SinglePairs<'_> {
    #[inline(always)]
    fn run<S: Simd, R: Roots<S> + Roots<S, f32>>(self, simd: S, roots: R) {
        let Self { sources, ranges, places, cell, ref own, least, fine, out } = self;
        let frame = CellFrame { center: cell.center.into(), inverse: 1.0 / cell.scale.max(least) };
        // The targets themselves come first: each has a pair of no distance.
        let split = |targets| {
            let all = ranges.iter().flat_map(Range::clone);
            all.filter(move |k| own.contains(k) == targets)
        };
        let point = |k: usize| frame.point(&sources.x, sources.charge[k], k);
        let points: Vec<_> = split(true).chain(split(false)).map(point).collect();
        let targets = split(true).count();
        let lanes = S::F32_LANES;
        for (first, out) in cell.bodies.clone().step_by(lanes).zip(out.chunks_mut(lanes)) {
            // Lanes without a target are at the center.
            let mut rows = [[0.0; LANES_F32]; 6];
            for k in 0..out.len() {
                let target = frame.point(places, 0.0, first + k);
                for d in 0..3 {
                    (rows[d][k], rows[3 + d][k]) = (target.x[d], target.rest[d]);
                }
            }
            let mut sums = [Lane::splat(simd, 0.0); 4];
            let (exact, coarse) = points.split_at(if fine { points.len() } else { targets });
            add_points::<S, R, true>(simd, roots, exact, &rows, &mut sums);
            let mut rough = sums;
            if add_points::<S, R, false>(simd, roots, coarse, &rows, &mut rough) < CLOSE * CLOSE {
                add_points::<S, R, true>(simd, roots, coarse, &rows, &mut sums);
            } else {
                sums = rough;
            }
            for (c, sum) in sums.iter().enumerate() {
                // A potential is an inverse length, a field one squared, of a half and a quarter.
                let unit = frame.inverse * if c == 0 { 1.0 } else { 0.25 * frame.inverse };
                for (out, lane) in out.iter_mut().zip(sum.numbers()) {
                    out[c] += unit * f64::from(*lane);
                }
            }
        }
    }
}

/// Adds the sums of `points` at a register of targets, without what the rounding of coordinates
/// leaves unless `FINE`, in units of [`double_rsqrt`](Roots::double_rsqrt). Returns the least
/// square of a distance, infinite for no points, and not found if `FINE`.
#[inline(always)]
fn add_points<S: Simd, R: Roots<S, f32>, const FINE: bool>(
    simd: S,
    roots: R,
    points: &[SplitPoint],
    targets: &[[f32; LANES_F32]; 6],
    totals: &mut [Lane<S, f32>; 4],
) -> f32 {
    let zero = Lane::splat(simd, 0.0);
    let (mut x, mut rest) = ([zero; 3], [zero; 3]);
    for d in 0..3 {
        x[d] = Lane::load(simd, &targets[d], 0);
        rest[d] = Lane::load(simd, &targets[3 + d], 0);
    }
    let mut least = Lane::splat(simd, f32::INFINITY);
    for tile in points.chunks(SOURCES_PER_SUM) {
        let mut sums = [zero; 4];
        for point in tile {
            let mut r = [zero; 3];
            for d in 0..3 {
                r[d] = Lane::splat(simd, point.x[d]) - x[d];
                if FINE {
                    r[d] = r[d] + (Lane::splat(simd, point.rest[d]) - rest[d]);
                }
            }
            let r2 = r[2].mul_add(r[2], r[1].mul_add(r[1], r[0] * r[0]));
            if !FINE {
                least = least.min(r2);
            }
            let inverse = roots.double_rsqrt(r2);
            let potential = Lane::splat(simd, point.charge) * inverse;
            sums[0] = sums[0] + potential;
            let force = potential * (inverse * inverse);
            for d in 0..3 {
                sums[d + 1] = force.mul_add(r[d], sums[d + 1]);
            }
        }
        for c in 0..4 {
            totals[c] = totals[c] + sums[c];
        }
    }
    least.numbers().iter().copied().fold(f32::INFINITY, f32::min)
}
