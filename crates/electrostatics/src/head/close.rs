//! Charged triangles and points near them, a point in each lane.

use super::triangle::Triangle;
use crate::lanes::{LANES, Lanes, Vectors};
use crate::machine::{Kernel, Machine, dispatch};
use crate::multipole::near::Cloud;
use pulp::Simd;
use std::ops::Range;

/// Adds to `out` what `triangles` with their charges make at the `targets` of `places`: `q/r` and its
/// gradient.
///
/// Cost: 10 ns for each point that is close to a triangle.
pub(super) fn add_fields(
    triangles: &[(&Triangle, f64)],
    places: &[Vec<f64>; 3],
    targets: Range<usize>,
    out: &mut [[f64; 4]],
) {
    dispatch(Fields { triangles, places, targets, out });
}

struct Fields<'a> {
    triangles: &'a [(&'a Triangle, f64)],
    places: &'a [Vec<f64>; 3],
    targets: Range<usize>,
    out: &'a mut [[f64; 4]],
}

impl Kernel for Fields<'_> {
    #[inline(always)]
    fn run<S: Simd, M: Machine<S>>(self, simd: S, machine: M) {
        let Self { triangles, places, targets, out } = self;
        for (first, out) in targets.step_by(S::F64_LANES).zip(out.chunks_mut(S::F64_LANES)) {
            let x = points(simd, places, first..first + out.len());
            let mut sums = [x[0].of(0.0); 4];
            for (triangle, charge) in triangles {
                let charge = x[0].of(*charge);
                for (sum, mean) in sums.iter_mut().zip(triangle.means(machine, &x)) {
                    *sum = mean.times_plus(charge, *sum);
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

/// Adds to `out` what the charges `ranges` of `cloud` make at a triangle: the mean of `q/r` over it, and
/// its gradient by its place.
pub(super) fn add_mean(
    triangle: &Triangle,
    cloud: &Cloud,
    ranges: &[Range<usize>],
    out: &mut [f64; 4],
) {
    dispatch(Mean { triangle, cloud, ranges, out });
}

struct Mean<'a> {
    triangle: &'a Triangle,
    cloud: &'a Cloud,
    ranges: &'a [Range<usize>],
    out: &'a mut [f64; 4],
}

impl Kernel for Mean<'_> {
    #[inline(always)]
    fn run<S: Simd, M: Machine<S>>(self, simd: S, machine: M) {
        let Self { triangle, cloud, ranges, out } = self;
        let mut sums = [Lanes::splat(simd, 0.0); 4];
        for range in ranges {
            for first in range.clone().step_by(S::F64_LANES) {
                let range = first..range.end.min(first + S::F64_LANES);
                let mut charges = [0.0; LANES];
                charges[..range.len()].copy_from_slice(&cloud.charge[range.clone()]);
                let charges = Lanes::load(simd, &charges);
                let means = triangle.means(machine, &points(simd, &cloud.x, range));
                for (sum, mean) in sums.iter_mut().zip(means) {
                    *sum = mean.times_plus(charges, *sum);
                }
            }
        }
        out[0] += sums[0].sum();
        for c in 1..4 {
            out[c] -= sums[c].sum();
        }
    }
}

/// A point in each lane; those without one repeat the first.
#[inline(always)]
fn points<S: Simd>(simd: S, places: &[Vec<f64>; 3], range: Range<usize>) -> Vectors<S> {
    let mut x = [Lanes::splat(simd, 0.0); 3];
    for (x, places) in x.iter_mut().zip(places) {
        let mut lanes = [places[range.start]; LANES];
        lanes[..range.len()].copy_from_slice(&places[range.clone()]);
        *x = Lanes::load(simd, &lanes);
    }
    x
}
