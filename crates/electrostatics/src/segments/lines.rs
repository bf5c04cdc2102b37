//! Segments in the order of a tree.

use super::skew::ChargedLine;
use nalgebra::{Point3, Vector3};
use pulp::Simd;
use rapunzel_lanes::{LANES, Lane};
use rayon::prelude::*;

/// Least distance (m) that two segments are taken to have: it keeps intersecting lines finite and
/// changes the force between touching hairs by 1e-10.
const CLOSEST: f64 = 1e-9;

/// Square of [`CLOSEST`], m^2, which is added to the square of a distance.
pub(super) const SOFTENING: f64 = CLOSEST * CLOSEST;

/// Segments, coordinate by coordinate.
pub(super) struct SegmentLines {
    /// Start (world, m), unit tangent and length (m) of each segment, for the closed form.
    ends: Vec<[f64; 7]>,
    /// Middle (world, m), half of the vector from start to end (m), length (m), its inverse (1/m)
    /// and charge, a row for each number.
    pub(super) bars: [Vec<f64>; 9],
    /// Square of the radius of each segment, m^2.
    softening: Vec<f64>,
    /// Fibre in the upper 32 bits, and index of the segment as it was given: neighbors differ by
    /// one.
    chain: Vec<u64>,
}

/// Energy, force on the start and force on the end of one segment, without Coulomb's constant.
pub(super) type Loads = [f64; 7];

impl SegmentLines {
    /// Segments between their two `ends` (world, m), with the squares of their radii (m^2) and
    /// their places in the `chain`.
    pub(super) fn new(
        ends: Vec<[Point3<f64>; 2]>,
        charges: Vec<f64>,
        softening: Vec<f64>,
        chain: Vec<u64>,
    ) -> Self {
        let row = |number: &(dyn Fn(&[Point3<f64>; 2]) -> f64 + Sync)| -> Vec<f64> {
            ends.par_iter().map(number).collect()
        };
        let middle = |d: usize| row(&|[a, b]| 0.5 * (a[d] + b[d]));
        let half = |d: usize| row(&|[a, b]| 0.5 * (b[d] - a[d]));
        let length = row(&|[a, b]| (b - a).norm());
        let inverse = length.par_iter().map(|length| 1.0 / length).collect();
        let bars =
            [middle(0), middle(1), middle(2), half(0), half(1), half(2), length, inverse, charges];
        let end = |[a, b]: [Point3<f64>; 2]| {
            let (length, [x, y, z]) = ((b - a).norm(), a.into());
            let tangent = (b - a) / length;
            [x, y, z, tangent.x, tangent.y, tangent.z, length]
        };
        Self { ends: ends.into_par_iter().map(end).collect(), bars, softening, chain }
    }

    /// Middle from `center` (m), half, length, its inverse and charge of segment `i`.
    pub(super) fn bar(&self, i: usize, center: [f64; 3]) -> [f64; 9] {
        let mut bar = [0.0; 9];
        bar.iter_mut().zip(&self.bars).for_each(|(bar, row)| *bar = row[i]);
        bar.iter_mut().zip(center).for_each(|(x, center)| *x -= center);
        bar
    }

    /// Number of segments.
    pub(super) fn count(&self) -> usize {
        self.chain.len()
    }

    /// Length of segment `i`, m.
    pub(super) fn length(&self, i: usize) -> f64 {
        self.bars[6][i]
    }

    /// Charge of segment `i`.
    pub(super) fn charge(&self, i: usize) -> f64 {
        self.bars[8][i]
    }

    /// Square of the length that the distance of segments `i` and `j` is softened with, m^2: the
    /// radius for neighbors on a fibre.
    pub(super) fn softening(&self, i: usize, j: usize) -> f64 {
        if self.chain[i].abs_diff(self.chain[j]) == 1 { self.softening[i] } else { SOFTENING }
    }

    /// Adds to `loads` the energy and the tension of segment `i` by itself:
    /// `q^2/L^2 (L asinh(L/a) - sqrt(L^2+a^2) + a)`, the mean of the kernel over both places on it.
    pub(super) fn add_self(&self, i: usize, loads: &mut Loads) {
        let (length, a2) = (self.length(i), self.softening[i]);
        let (a, q) = (a2.sqrt(), self.charge(i));
        let slope = (length / a).asinh();
        let g = (length * slope - (length * length + a2).sqrt() + a) / length;
        loads[0] += q * q * g / length;
        for c in 0..3 {
            let push = q * q * (2.0 * g - slope) / (length * length) * self.ends[i][3 + c];
            loads[1 + c] -= push;
            loads[4 + c] += push;
        }
    }

    /// Square of the sine of the angle between segments `i` and `j`.
    pub(super) fn sine2(&self, i: usize, j: usize) -> f64 {
        let tangent = |i: usize| Vector3::from_column_slice(&self.ends[i][3..6]);
        tangent(i).cross(&tangent(j)).norm_squared()
    }

    /// Segments with these indices, one in each lane.
    #[inline(always)]
    pub(super) fn gather<S: Simd>(&self, simd: S, indices: &[usize; LANES]) -> ChargedLine<S> {
        let mut values = [[0.0; LANES]; 7];
        for (k, &j) in indices.iter().enumerate() {
            for (values, value) in values.iter_mut().zip(&self.ends[j]) {
                values[k] = *value;
            }
        }
        let mut lanes = [Lane::splat(simd, 0.0); 7];
        for (lanes, values) in lanes.iter_mut().zip(&values) {
            *lanes = Lane::load(simd, values, 0);
        }
        let [x, y, z, tx, ty, tz, length] = lanes;
        ChargedLine { start: [x, y, z], tangent: [tx, ty, tz], length }
    }
}
