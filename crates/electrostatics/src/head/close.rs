//! Charged triangles and points near them, a point in each lane.

use super::triangle::Triangle;
use crate::direct_sum::Cloud;
use crate::vectors::LaneVector;
use pulp::Simd;
use rapunzel_lanes::{Kernel, LANES, Lane, Machine, dispatch};
use std::ops::Range;

/// Adds to `out` the potentials `q/r` and their gradients that `triangles` with their charges make
/// at the `targets` of `places` (world, m).
///
/// Cost: 10 ns for each point that is close to a triangle.
pub(super) fn add_fields(
    triangles: &[(&Triangle, f64)],
    places: &[Vec<f64>; 3],
    targets: Range<usize>,
    out: &mut [[f64; 4]],
) {
    dispatch(TriangleFields { triangles, places, targets, out });
}

/// Arguments of [`add_fields`].
struct TriangleFields<'a> {
    triangles: &'a [(&'a Triangle, f64)],
    places: &'a [Vec<f64>; 3],
    targets: Range<usize>,
    out: &'a mut [[f64; 4]],
}

impl Kernel for TriangleFields<'_> {
    #[inline(always)]
    fn run<S: Simd, M: Machine<S>>(self, simd: S, machine: M) {
        let Self { triangles, places, targets, out } = self;
        for (first, out) in targets.step_by(S::F64_LANES).zip(out.chunks_mut(S::F64_LANES)) {
            let x = points(simd, places, first..first + out.len());
            let mut sums = [x[0].lift(0.0); 4];
            for (triangle, charge) in triangles {
                let charge = x[0].lift(*charge);
                for (sum, mean) in sums.iter_mut().zip(triangle.means(machine, &x)) {
                    *sum = mean.mul_add(charge, *sum);
                }
            }
            for (c, sum) in sums.iter().enumerate() {
                for (out, lane) in out.iter_mut().zip(sum.numbers()) {
                    out[c] += lane;
                }
            }
        }
    }
}

/// Adds to `out` the mean of `q/r` of the charges `ranges` of `cloud` over a triangle, and the
/// gradient of the mean by the place of the triangle.
pub(super) fn add_mean(
    triangle: &Triangle,
    cloud: &Cloud,
    ranges: &[Range<usize>],
    out: &mut [f64; 4],
) {
    dispatch(TriangleMean { triangle, cloud, ranges, out });
}

/// Arguments of [`add_mean`].
struct TriangleMean<'a> {
    triangle: &'a Triangle,
    cloud: &'a Cloud,
    ranges: &'a [Range<usize>],
    out: &'a mut [f64; 4],
}

impl Kernel for TriangleMean<'_> {
    #[inline(always)]
    fn run<S: Simd, M: Machine<S>>(self, simd: S, machine: M) {
        let Self { triangle, cloud, ranges, out } = self;
        let mut sums = [Lane::splat(simd, 0.0); 4];
        for range in ranges {
            for first in range.clone().step_by(S::F64_LANES) {
                let range = first..range.end.min(first + S::F64_LANES);
                let mut charges = [0.0; LANES];
                charges[..range.len()].copy_from_slice(&cloud.charge[range.clone()]);
                let charges = Lane::load(simd, &charges, 0);
                let means = triangle.means(machine, &points(simd, &cloud.x, range));
                for (sum, mean) in sums.iter_mut().zip(means) {
                    *sum = mean.mul_add(charges, *sum);
                }
            }
        }
        out[0] += sums[0].reduce_sum();
        for c in 1..4 {
            out[c] -= sums[c].reduce_sum();
        }
    }
}

/// Points `range` of `places` (world, m), one in each lane; lanes without one repeat the first.
#[inline(always)]
fn points<S: Simd>(simd: S, places: &[Vec<f64>; 3], range: Range<usize>) -> LaneVector<S> {
    let mut x = [Lane::splat(simd, 0.0); 3];
    for (x, places) in x.iter_mut().zip(places) {
        let mut lanes = [places[range.start]; LANES];
        lanes[..range.len()].copy_from_slice(&places[range.clone()]);
        *x = Lane::load(simd, &lanes, 0);
    }
    x
}
