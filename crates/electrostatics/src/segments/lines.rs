//! Segments in the order of a tree.

use super::skew::Line;
use crate::lanes::{LANES, Lanes};
use nalgebra::Point3;
use pulp::Simd;

/// Length that no two segments are taken to be closer than, m: it keeps intersecting lines finite and
/// changes the force between touching hairs by 1e-10.
const CLOSEST: f64 = 1e-9;

/// What [`CLOSEST`] adds to the square of a distance, m^2.
pub(super) const SOFTENING: f64 = CLOSEST * CLOSEST;

/// Segments coordinate by coordinate.
#[derive(Default)]
pub(super) struct Lines {
    pub(super) start: [Vec<f64>; 3],
    pub(super) tangent: [Vec<f64>; 3],
    middle: [Vec<f64>; 3],
    /// Half of each segment.
    half: [Vec<f64>; 3],
    pub(super) length: Vec<f64>,
    inverse_length: Vec<f64>,
    pub(super) charge: Vec<f64>,
    /// Square of the radius.
    softening: Vec<f64>,
    fiber: Vec<u32>,
    /// Index of the segment as it was given.
    index: Vec<u32>,
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
        for c in 0..3 {
            let half = 0.5 * (end - start)[c];
            self.start[c].push(start[c]);
            self.tangent[c].push((end - start)[c] / length);
            self.middle[c].push(start[c] + half);
            self.half[c].push(half);
        }
        self.length.push(length);
        self.inverse_length.push(1.0 / length);
        self.charge.push(charge);
        self.softening.push(radius * radius);
        self.fiber.push(fiber);
        self.index.push(index);
    }

    /// Half of segment `i`, as a vector.
    pub(super) fn half(&self, i: usize) -> [f64; 3] {
        [0, 1, 2].map(|c| self.half[c][i])
    }

    /// The middle of segment `i`.
    pub(super) fn middle(&self, i: usize) -> [f64; 3] {
        [0, 1, 2].map(|c| self.middle[c][i])
    }

    /// Middle from `center`, half, length, its inverse and charge of segment `i`.
    pub(super) fn bar(&self, i: usize, center: [f64; 3]) -> [f64; 9] {
        let ([x, y, z], [a, b, c]) = (self.middle(i), self.half(i));
        let (length, inverse) = (self.length[i], self.inverse_length[i]);
        [x - center[0], y - center[1], z - center[2], a, b, c, length, inverse, self.charge[i]]
    }

    /// Square of the length that the distance of two segments is softened with.
    pub(super) fn softening(&self, i: usize, j: usize) -> f64 {
        let neighbors = self.index[i].abs_diff(self.index[j]) == 1;
        if neighbors && self.fiber[i] == self.fiber[j] { self.softening[i] } else { SOFTENING }
    }

    /// Adds energy and tension of a segment by itself: `q^2/L^2 (L asinh(L/a) - sqrt(L^2+a^2) + a)`.
    pub(super) fn add_self(&self, i: usize, loads: &mut Loads) {
        let (length, a2) = (self.length[i], self.softening[i]);
        let (a, q) = (a2.sqrt(), self.charge[i]);
        let slope = (length / a).asinh();
        let g = (length * slope - (length * length + a2).sqrt() + a) / length;
        loads[0] += q * q * g / length;
        for c in 0..3 {
            let push = q * q * (2.0 * g - slope) / (length * length) * self.tangent[c][i];
            loads[1 + c] -= push;
            loads[4 + c] += push;
        }
    }

    /// A segment in each lane.
    #[inline(always)]
    pub(super) fn gather<S: Simd>(&self, simd: S, indices: &[usize; LANES]) -> Line<S> {
        let mut values = [[0.0; LANES]; 7];
        for (k, &j) in indices.iter().enumerate() {
            for c in 0..3 {
                values[c][k] = self.start[c][j];
                values[3 + c][k] = self.tangent[c][j];
            }
            values[6][k] = self.length[j];
        }
        let mut lanes = [Lanes::splat(simd, 0.0); 7];
        for (lanes, values) in lanes.iter_mut().zip(&values) {
            *lanes = Lanes::load(simd, values);
        }
        let [x, y, z, tx, ty, tz, length] = lanes;
        Line { start: [x, y, z], tangent: [tx, ty, tz], length }
    }
}
