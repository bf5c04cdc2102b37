//! Points into expansions and expansions at points, points in the lanes.

use super::tree::Cell;
use crate::direct_sum::Cloud;
use crate::harmonics::{Gradient, HarmonicTables, count, regular};
use aligned_vec::{AVec, ConstAlign, avec};
use pulp::{Arch, Simd, WithSimd};
use rapunzel_lanes::{LANES, Lane};
use std::ops::Range;

/// Scratch space for the harmonics of some points, aligned to registers.
pub(super) type Work = AVec<f64, ConstAlign<64>>;

/// Scratch space for two sets of harmonics up to degree `order`.
pub(super) fn work(order: usize) -> Work {
    avec![[64]| 0.0; 2 * count(order) * LANES]
}

/// Sets `moments` to the coefficients of the multipole of the points `range` of `cloud` about the
/// center of `cell` (P2M): sums of charge times `R_nm`.
///
/// Cost: 4 operations a point and coefficient.
pub(super) fn multipole(
    order: usize,
    cell: &Cell,
    cloud: &Cloud,
    range: Range<usize>,
    work: &mut Work,
    moments: &mut [f64],
) {
    Arch::new().dispatch(PointMultipole { order, cell, cloud, range, work, moments });
}

/// Arguments of [`multipole`].
struct PointMultipole<'a> {
    order: usize,
    cell: &'a Cell,
    cloud: &'a Cloud,
    range: Range<usize>,
    work: &'a mut [f64],
    moments: &'a mut [f64],
}

impl WithSimd for PointMultipole<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { order, cell, cloud, range, work, moments } = self;
        let size = count(order);
        let (work, _) = S::as_mut_simd_f64s(work);
        let (values, rest) = work.split_at_mut(size);
        let totals = &mut rest[..size];
        totals.fill(Lane::splat(simd, 0.0).value);
        for first in range.clone().step_by(S::F64_LANES) {
            let end = range.end.min(first + S::F64_LANES);
            let x = places(simd, cell, &cloud.x, first..end);
            let mut charges = [0.0; LANES];
            charges[..end - first].copy_from_slice(&cloud.charge[first..end]);
            let charge = Lane::load(simd, &charges, 0);
            regular(HarmonicTables::get(), order, x, values);
            for (total, value) in totals.iter_mut().zip(&*values) {
                *total = charge.mul_add(Lane::new(simd, *value), Lane::new(simd, *total)).value;
            }
        }
        for (moment, total) in moments.iter_mut().zip(totals) {
            *moment = Lane::new(simd, *total).reduce_sum();
        }
    }
}

/// Positions of the points `range` of `places` from the center of `cell`, over its scale, at most
/// one in each lane; lanes without a point hold the center.
#[inline(always)]
fn places<S: Simd>(
    simd: S,
    cell: &Cell,
    places: &[Vec<f64>; 3],
    range: Range<usize>,
) -> [Lane<S>; 3] {
    let inverse = Lane::splat(simd, 1.0 / cell.scale);
    let mut out = [inverse; 3];
    for d in 0..3 {
        let mut lanes = [cell.center[d]; LANES];
        lanes[..range.len()].copy_from_slice(&places[d][range.clone()]);
        let offset = Lane::load(simd, &lanes, 0) - inverse.lift(cell.center[d]);
        out[d] = offset * inverse;
    }
    out
}

/// Adds to `out` the potential (1/m) and its gradient (1/m^2), for the charges of the sources, of
/// the expansion `local` at the points `range` (L2P).
///
/// Cost: 7 operations a point and coefficient.
pub(super) fn add_local(
    order: usize,
    cell: &Cell,
    local: &Gradient,
    points: &[Vec<f64>; 3],
    range: Range<usize>,
    work: &mut Work,
    out: &mut [[f64; 4]],
) {
    Arch::new().dispatch(LocalEvaluation { order, cell, local, points, range, work, out });
}

/// Arguments of [`add_local`].
struct LocalEvaluation<'a> {
    order: usize,
    cell: &'a Cell,
    local: &'a Gradient,
    points: &'a [Vec<f64>; 3],
    range: Range<usize>,
    work: &'a mut [f64],
    out: &'a mut [[f64; 4]],
}

impl WithSimd for LocalEvaluation<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { order, cell, local, points, range, work, out } = self;
        let (work, _) = S::as_mut_simd_f64s(work);
        let values = &mut work[..count(order)];
        for (first, out) in range.step_by(S::F64_LANES).zip(out.chunks_mut(S::F64_LANES)) {
            let x = places(simd, cell, points, first..first + out.len());
            regular(HarmonicTables::get(), order, x, values);
            let mut sums = [Lane::splat(simd, 0.0); 4];
            for (terms, value) in local.terms.iter().zip(&*values) {
                for (sum, term) in sums.iter_mut().zip(terms) {
                    *sum = sum.lift(*term).mul_add(Lane::new(simd, *value), *sum);
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
