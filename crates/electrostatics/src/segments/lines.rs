//! Segments in the order of a tree.

use super::skew::Line;
use crate::lanes::{LANES, Lanes};
use nalgebra::{Point3, Vector3};
use pulp::Simd;

/// Length that no two segments are taken to be closer than, m: it keeps intersecting lines finite and
/// changes the force between touching hairs by 1e-10.
const CLOSEST: f64 = 1e-9;

/// What [`CLOSEST`] adds to the square of a distance, m^2.
pub(super) const SOFTENING: f64 = CLOSEST * CLOSEST;

/// Segments coordinate by coordinate.
#[derive(Default)]
pub(super) struct Lines {
    /// Start, tangent and length, for the closed form.
    ends: Vec<[f64; 7]>,
    /// Middle, half, length, its inverse, and charge.
    pub(super) bars: [Vec<f64>; 9],
    /// Square of the radius.
    softening: Vec<f64>,
    /// Fibre, and index of the segment as it was given: neighbors differ by one.
    chain: Vec<u64>,
}

/// Energy, force on the start and force on the end of one segment, without Coulomb's constant.
pub(super) type Loads = [f64; 7];

impl Lines {
    /// Adds the segment `index` of `fiber`.
    pub(super) fn push(
        &mut self,
        [start, end]: [Point3<f64>; 2],
        charge: f64,
        radius: f64,
        [fiber, index]: [u32; 2],
    ) {
        let length = (end - start).norm();
        let half = 0.5 * (end - start);
        let tangent = (end - start) / length;
        self.ends.push([start.x, start.y, start.z, tangent.x, tangent.y, tangent.z, length]);
        let [x, y, z] = (start + half).into();
        let bar = [x, y, z, half.x, half.y, half.z, length, 1.0 / length, charge];
        self.bars.iter_mut().zip(bar).for_each(|(row, value)| row.push(value));
        self.softening.push(radius * radius);
        self.chain.push((u64::from(fiber) << 32) | u64::from(index));
    }

    /// Middle from `center`, half, length, its inverse and charge of segment `i`.
    pub(super) fn bar(&self, i: usize, center: [f64; 3]) -> [f64; 9] {
        let mut bar = [0.0; 9];
        bar.iter_mut().zip(&self.bars).for_each(|(bar, row)| *bar = row[i]);
        bar.iter_mut().zip(center).for_each(|(x, center)| *x -= center);
        bar
    }

    /// How many they are.
    pub(super) fn count(&self) -> usize {
        self.chain.len()
    }

    /// Length of segment `i`.
    pub(super) fn length(&self, i: usize) -> f64 {
        self.bars[6][i]
    }

    /// Charge of segment `i`.
    pub(super) fn charge(&self, i: usize) -> f64 {
        self.bars[8][i]
    }

    /// Square of the length that the distance of two segments is softened with.
    pub(super) fn softening(&self, i: usize, j: usize) -> f64 {
        if self.chain[i].abs_diff(self.chain[j]) == 1 { self.softening[i] } else { SOFTENING }
    }

    /// Adds energy and tension of a segment by itself: `q^2/L^2 (L asinh(L/a) - sqrt(L^2+a^2) + a)`.
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

    /// Square of the sine of the angle of two segments.
    pub(super) fn sine2(&self, i: usize, j: usize) -> f64 {
        let tangent = |i: usize| Vector3::from_column_slice(&self.ends[i][3..6]);
        tangent(i).cross(&tangent(j)).norm_squared()
    }

    /// A segment in each lane.
    #[inline(always)]
    pub(super) fn gather<S: Simd>(&self, simd: S, indices: &[usize; LANES]) -> Line<S> {
        let mut values = [[0.0; LANES]; 7];
        for (k, &j) in indices.iter().enumerate() {
            for (values, value) in values.iter_mut().zip(&self.ends[j]) {
                values[k] = *value;
            }
        }
        let mut lanes = [Lanes::splat(simd, 0.0); 7];
        for (lanes, values) in lanes.iter_mut().zip(&values) {
            *lanes = Lanes::load(simd, values);
        }
        let [x, y, z, tx, ty, tz, length] = lanes;
        Line { start: [x, y, z], tangent: [tx, ty, tz], length }
    }
}
