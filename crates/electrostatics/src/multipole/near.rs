//! The direct sum over pairs of points, targets in the lanes.

use crate::vectors::Vectors;
use pulp::Simd;
use rapunzel_lanes::{Kernel, LANES, Lane, Roots, dispatch};
use std::ops::Range;
use std::sync::Arc;

/// Positions, coordinate by coordinate, which may be shared, and charges.
#[derive(Debug, Clone)]
pub(crate) struct Cloud {
    pub(crate) x: Arc<[Vec<f64>; 3]>,
    pub(crate) charge: Vec<f64>,
}

impl Cloud {
    pub(crate) fn new(x: [Vec<f64>; 3], charge: Vec<f64>) -> Self {
        Self { x: Arc::new(x), charge }
    }

    pub(crate) fn len(&self) -> usize {
        self.charge.len()
    }
}

/// Adds to `out[k]` the potential and the negative field, over Coulomb's constant, that the
/// `ranges` of `sources` make at target `targets.start + k`, with the kernel `1/sqrt(r^2 +
/// softening)`. Without softening, targets that coincide with a source do not feel it.
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
    dispatch(Pairs { sources, ranges, softening, places, targets, out });
}

struct Pairs<'a> {
    sources: &'a Cloud,
    ranges: &'a [Range<usize>],
    softening: f64,
    places: &'a [Vec<f64>; 3],
    targets: Range<usize>,
    out: &'a mut [[f64; 4]],
}

impl Kernel for Pairs<'_> {
    #[inline(always)]
    fn run<S: Simd, R: Roots<S>>(self, simd: S, roots: R) {
        let Self { sources, ranges, softening, places, targets, out } = self;
        let softening = Lane::splat(simd, softening);
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

#[inline(always)]
fn pair<S: Simd, R: Roots<S>>(
    roots: R,
    place: &Vectors<S>,
    source: &Vectors<S>,
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
