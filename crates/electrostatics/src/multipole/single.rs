//! The direct sum over pairs of points in single precision.
//!
//! Each coordinate is a sum of two numbers, the second as small as the rounding of the first, so that
//! points that are close to each other are at the right distance.

use super::near::Cloud;
use super::tree::Cell;
use crate::lanes::{Kernel, LANES, Lanes, Roots, dispatch};
use pulp::Simd;
use std::ops::Range;

/// Sources that are taken at once; their sum is added in double precision.
const TILE: usize = 256;

/// Targets in two registers.
const BLOCK: usize = 4 * LANES;

/// As [`add_pairs`](super::near::add_pairs) without softening, for targets in `cell`, to some 1e-6 of
/// each pair. Lengths are divided by the larger of the cell's radius and `least`, which keeps all
/// powers of distances within range.
///
/// Cost: 0.2 ns a pair with AVX-512.
pub(crate) fn add_pairs_single(
    sources: &Cloud,
    ranges: &[Range<usize>],
    places: &[Vec<f64>; 3],
    cell: &Cell,
    least: f64,
    out: &mut [[f64; 4]],
) {
    dispatch(Pairs { sources, ranges, places, cell, least, out });
}

struct Pairs<'a> {
    sources: &'a Cloud,
    ranges: &'a [Range<usize>],
    places: &'a [Vec<f64>; 3],
    cell: &'a Cell,
    least: f64,
    out: &'a mut [[f64; 4]],
}

/// Some points: coordinates, what their rounding leaves, and charges.
struct Tile<const N: usize> {
    x: [[f32; N]; 3],
    rest: [[f32; N]; 3],
    charge: [f32; N],
}

impl<const N: usize> Tile<N> {
    const EMPTY: Self = Self { x: [[0.0; N]; 3], rest: [[0.0; N]; 3], charge: [0.0; N] };

    /// Takes the coordinates from `center` in units of `1/scale`.
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
    fn fill(&mut self, places: [&[f64]; 3], center: [f64; 3], scale: f64) {
        for d in 0..3 {
            let lanes = self.x[d].iter_mut().zip(&mut self.rest[d]);
            for ((x, rest), place) in lanes.zip(places[d]) {
                let exact = (place - center[d]) * scale;
                *x = exact as f32;
                *rest = (exact - f64::from(*x)) as f32;
            }
        }
    }
}

impl Kernel for Pairs<'_> {
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "charges are about one")]
    fn run<S: Simd, R: Roots<S> + Roots<S, f32>>(self, simd: S, roots: R) {
        let Self { sources, ranges, places, cell, least, out } = self;
        let scale = 1.0 / cell.scale.max(least);
        let center = cell.center.into();
        let (mut tile, mut targets) = (Tile::<TILE>::EMPTY, Tile::<BLOCK>::EMPTY);
        for range in ranges {
            for first in range.clone().step_by(TILE) {
                let range = first..range.end.min(first + TILE);
                tile.fill([0, 1, 2].map(|d| &sources.x[d][range.clone()]), center, scale);
                for (to, from) in tile.charge.iter_mut().zip(&sources.charge[range.clone()]) {
                    *to = *from as f32;
                }
                let lanes = 2 * S::F32_LANES;
                let bodies = cell.bodies.clone().step_by(lanes);
                for (first, out) in bodies.zip(out.chunks_mut(lanes)) {
                    let own = first..first + out.len();
                    targets.fill([0, 1, 2].map(|d| &places[d][own.clone()]), center, scale);
                    let sums = add_tile(simd, roots, &tile, range.len(), &targets);
                    for (sums, out) in sums.iter().zip(out.chunks_mut(S::F32_LANES)) {
                        for (c, sum) in sums.iter().enumerate() {
                            // A potential is an inverse length, a field one squared.
                            let unit = if c == 0 { scale } else { scale * scale };
                            for (out, lane) in out.iter_mut().zip(sum.numbers()) {
                                out[c] += unit * f64::from(*lane);
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The sums of the first `count` points of `tile` at two registers of targets.
#[inline(always)]
fn add_tile<S: Simd, R: Roots<S, f32>>(
    simd: S,
    roots: R,
    tile: &Tile<TILE>,
    count: usize,
    targets: &Tile<BLOCK>,
) -> [[Lanes<S, f32>; 4]; 2] {
    let zero = Lanes::splat(simd, 0.0);
    let (mut x, mut rest) = ([[zero; 3]; 2], [[zero; 3]; 2]);
    for k in 0..2 {
        for d in 0..3 {
            x[k][d] = Lanes::load(simd, &targets.x[d][k * S::F32_LANES..]);
            rest[k][d] = Lanes::load(simd, &targets.rest[d][k * S::F32_LANES..]);
        }
    }
    let mut sums = [[zero; 4]; 2];
    for j in 0..count {
        let charge = Lanes::all(simd, tile.charge[j]);
        for k in 0..2 {
            let mut r = [zero; 3];
            for d in 0..3 {
                let difference = Lanes::all(simd, tile.rest[d][j]) - rest[k][d];
                r[d] = (Lanes::all(simd, tile.x[d][j]) - x[k][d]) + difference;
            }
            let r2 = r[2].times_plus(r[2], r[1].times_plus(r[1], r[0] * r[0]));
            let inverse = roots.inverse_root(r2);
            let potential = charge * inverse;
            sums[k][0] = sums[k][0] + potential;
            let force = potential * (inverse * inverse);
            for d in 0..3 {
                sums[k][d + 1] = force.times_plus(r[d], sums[k][d + 1]);
            }
        }
    }
    sums
}
