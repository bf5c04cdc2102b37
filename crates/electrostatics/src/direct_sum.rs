//! The direct sum over pairs of points, targets in the lanes.

use crate::vectors::LaneVector;
use nalgebra::Point3;
use pulp::Simd;
use rapunzel_lanes::{Kernel, LANES, Lane, Roots, dispatch};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Point charges: positions, coordinate by coordinate, which may be shared, and charges.
#[derive(Debug, Clone)]
pub(crate) struct Cloud {
    /// Coordinates (world), m.
    pub(crate) x: Arc<[Vec<f64>; 3]>,
    /// Charges in a unit of the caller.
    pub(crate) charge: Vec<f64>,
}

impl Cloud {
    /// Charges at the places `x`.
    pub(crate) fn new(x: [Vec<f64>; 3], charge: Vec<f64>) -> Self {
        Self { x: Arc::new(x), charge }
    }

    /// Number of points.
    pub(crate) fn len(&self) -> usize {
        self.charge.len()
    }
}

/// Adds to `out[k]` the potential and the negative field, over Coulomb's constant, that the
/// `ranges` of `sources` make at target `targets.start + k`, with the kernel
/// `1/sqrt(r^2 + softening)`. Without softening, targets that coincide with a source do not feel
/// it.
///
/// Cost: 0.4 ns a pair with AVX-512.
pub(crate) fn add_pairs(
    sources: &Cloud,
    ranges: &[Range<usize>],
    softening: f64,
    places: &[Vec<f64>; 3],
    targets: Range<usize>,
    out: &mut [[f64; 4]],
) {
    dispatch(PointPairs { sources, ranges, softening, places, targets, out });
}

/// Arguments of [`add_pairs`].
struct PointPairs<'a> {
    sources: &'a Cloud,
    ranges: &'a [Range<usize>],
    softening: f64,
    places: &'a [Vec<f64>; 3],
    targets: Range<usize>,
    out: &'a mut [[f64; 4]],
}

impl Kernel for PointPairs<'_> {
    #[inline(always)]
    fn run<S: Simd, R: Roots<S>>(self, simd: S, roots: R) {
        let Self { sources, ranges, softening, places, targets, out } = self;
        let softening = Lane::splat(simd, softening);
        // Targets are taken two registers at a time.
        let block = 2 * S::F64_LANES;
        let mut buffer = [[0.0; 2 * LANES]; 3];
        for (first, out) in targets.step_by(block).zip(out.chunks_mut(block)) {
            for d in 0..3 {
                // Lanes without a target repeat the first one.
                buffer[d].fill(places[d][first]);
                buffer[d][..out.len()].copy_from_slice(&places[d][first..first + out.len()]);
            }
            let mut places = [[softening; 3]; 2];
            for d in 0..3 {
                for (k, place) in places.iter_mut().enumerate() {
                    place[d] = Lane::load(simd, &buffer[d], k);
                }
            }
            let mut sums = [[Lane::splat(simd, 0.0); 4]; 2];
            for range in ranges {
                let [xs, ys, zs, qs] = [
                    &sources.x[0][range.clone()],
                    &sources.x[1][range.clone()],
                    &sources.x[2][range.clone()],
                    &sources.charge[range.clone()],
                ];
                for (((sx, sy), sz), q) in xs.iter().zip(ys).zip(zs).zip(qs) {
                    let source = [softening.lift(*sx), softening.lift(*sy), softening.lift(*sz)];
                    let charge = softening.lift(*q);
                    for k in 0..2 {
                        pair(roots, &places[k], &source, [charge, softening], &mut sums[k]);
                    }
                }
            }
            for (sums, out) in sums.iter().zip(out.chunks_mut(S::F64_LANES)) {
                for (c, sum) in sums.iter().enumerate() {
                    for (out, lane) in out.iter_mut().zip(sum.numbers()) {
                        out[c] += lane;
                    }
                }
            }
        }
    }
}

/// Adds the action of one source on a register of targets: `q/r` and `q d/r^3` with the vector d
/// from the target to the source.
#[inline(always)]
fn pair<S: Simd, R: Roots<S>>(
    roots: R,
    place: &LaneVector<S>,
    source: &LaneVector<S>,
    [charge, softening]: [Lane<S>; 2],
    sums: &mut [Lane<S>; 4],
) {
    let d = [source[0] - place[0], source[1] - place[1], source[2] - place[2]];
    let r2 = d[2].mul_add(d[2], d[1].mul_add(d[1], d[0].mul_add(d[0], softening)));
    let inverse = roots.rsqrt(r2);
    let potential = charge * inverse;
    sums[0] = sums[0] + potential;
    let force = potential * (inverse * inverse);
    for k in 0..3 {
        sums[k + 1] = force.mul_add(d[k], sums[k + 1]);
    }
}

/// Coordinates of points (world, m), one array for each axis.
pub(crate) fn places(points: impl IndexedParallelIterator<Item = Point3<f64>>) -> [Vec<f64>; 3] {
    // Points may stand anywhere in memory: they are fetched once.
    let points: Vec<_> = points.collect();
    [0, 1, 2].map(|d| points.par_iter().map(|x| x[d]).collect())
}

/// Sums of `q/sqrt(r^2 + softening)` and their gradients at `targets` (world, m), for all charges
/// of `cloud`; the same bits for any number of threads.
pub(crate) fn direct_sums(cloud: &Cloud, softening: f64, targets: &[Vec<f64>; 3]) -> Vec<[f64; 4]> {
    // Sources are taken a level-2 cache at a time.
    const SOURCES_PER_TILE: usize = 16_384;
    const TARGETS: usize = 64;
    let tiles = cloud.len().div_ceil(SOURCES_PER_TILE);
    let mut sums = vec![[0.0; 4]; targets[0].len()];
    sums.par_chunks_mut(TARGETS).enumerate().for_each(|(k, out)| {
        let range = k * TARGETS..k * TARGETS + out.len();
        let part = |k: usize| {
            let (tile, mut part) = (
                k * SOURCES_PER_TILE..cloud.len().min((k + 1) * SOURCES_PER_TILE),
                [[0.0; 4]; TARGETS],
            );
            let part = &mut part[..out.len()];
            add_pairs(cloud, &[tile], softening, targets, range.clone(), part);
            part.to_vec()
        };
        let parts: Vec<_> = (0..tiles).into_par_iter().map(part).collect();
        for part in parts {
            let sums = out.as_flattened_mut().iter_mut();
            sums.zip(part.as_flattened()).for_each(|(sum, part)| *sum += part);
        }
    });
    sums
}
