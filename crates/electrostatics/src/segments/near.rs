//! Pairs of segments that are close to each other.
//!
//! All near pairs are first taken as points. What this lacks for close ones is added here: the
//! closed form less the points.

use super::skew::{Line, Means, parallel, skew};
use crate::lanes::{Kernel, LANES, Lanes, Roots, along, dispatch, dot, minus, scaled};
use crate::multipole::engine::Task;
use nalgebra::{Point3, Vector3};
use pulp::Simd;
use std::ops::Range;

/// Length that no two segments are taken to be closer than, m: it keeps intersecting lines finite and
/// changes the force between touching hairs by 1e-10.
const CLOSEST: f64 = 1e-9;

/// What [`CLOSEST`] adds to the square of a distance, m^2.
pub(super) const SOFTENING: f64 = CLOSEST * CLOSEST;

/// Segments in the order of a tree, coordinate by coordinate.
pub(super) struct Lines {
    start: [Vec<f64>; 3],
    tangent: [Vec<f64>; 3],
    middle: [Vec<f64>; 3],
    length: Vec<f64>,
    charge: Vec<f64>,
    /// Square of the radius.
    softening: Vec<f64>,
    fiber: Vec<u32>,
    /// Index of the segment as it was given.
    index: Vec<u32>,
    /// Places of the points on a segment from 0 to 1, and their shares of its charge.
    rule: Vec<[f64; 2]>,
    /// The sine of the angle up to which two are nearly parallel.
    parallel: f64,
}

/// Energy, force on the start and force on the end of one segment, without Coulomb's constant.
pub(super) type Loads = [f64; 7];

impl Lines {
    /// Segments are added by [`push`](Self::push); in sums they are taken as the points of `rule`, which
    /// runs from -1 to 1, and as parallel up to angles of the sine `parallel`.
    pub(super) fn new(rule: &[[f64; 2]], parallel: f64) -> Self {
        Self {
            start: Default::default(),
            tangent: Default::default(),
            middle: Default::default(),
            length: Vec::new(),
            charge: Vec::new(),
            softening: Vec::new(),
            fiber: Vec::new(),
            index: Vec::new(),
            rule: rule.iter().map(|[x, w]| [0.5 + 0.5 * x, 0.5 * w]).collect(),
            parallel,
        }
    }

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
            self.start[c].push(start[c]);
            self.tangent[c].push((end - start)[c] / length);
            self.middle[c].push(0.5 * (start[c] + end[c]));
        }
        self.length.push(length);
        self.charge.push(charge);
        self.softening.push(radius * radius);
        self.fiber.push(fiber);
        self.index.push(index);
    }

    /// Adds to the loads of the segments `bodies` of `task` what they and the segments of `near` lack
    /// as points, if their middles are closer than `reach` times their mean length. In a complete task
    /// this adds to both of a pair at once.
    pub(super) fn add_close(
        &self,
        bodies: Range<usize>,
        near: &[Range<usize>],
        reach: f64,
        task: Task<Loads>,
    ) {
        dispatch(Close { lines: self, bodies, near, reach, task });
    }

    /// Energy and tension of a segment by itself: `q^2/L^2 (L asinh(L/a) - sqrt(L^2+a^2) + a)`, less
    /// those of its points.
    fn add_self(&self, i: usize, loads: &mut Loads) {
        let (length, a2) = (self.length[i], self.softening[i]);
        let (a, q) = (a2.sqrt(), self.charge[i]);
        let slope = (length / a).asinh();
        let g = (length * slope - (length * length + a2).sqrt() + a) / length;
        let [mut energy, mut push] = [g / length, (2.0 * g - slope) / (length * length)];
        for [u, w] in &self.rule {
            for [v, x] in &self.rule {
                let r = (u - v) * length;
                let inverse = 1.0 / (r * r + SOFTENING).sqrt();
                energy -= 0.5 * w * x * inverse;
                push -= u * w * x * r * inverse.powi(3);
            }
        }
        loads[0] += q * q * energy;
        for c in 0..3 {
            let push = q * q * push * self.tangent[c][i];
            loads[1 + c] -= push;
            loads[4 + c] += push;
        }
    }

    #[inline(always)]
    fn gather<S: Simd>(&self, simd: S, indices: &[usize; LANES]) -> Line<S> {
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

struct Close<'a> {
    lines: &'a Lines,
    bodies: Range<usize>,
    near: &'a [Range<usize>],
    reach: f64,
    task: Task<'a, Loads>,
}

impl Kernel for Close<'_> {
    #[inline(always)]
    fn run<S: Simd, R: Roots<S>>(mut self, simd: S, roots: R) {
        let mut found = Partners::default();
        for i in self.bodies.clone() {
            // Bodies whose pairs with i are counted once for both.
            let both = if self.task.complete { self.task.bodies.clone() } else { i..i + 1 };
            found.askew.clear();
            found.parallel.clear();
            for near in self.near {
                for part in [0..both.start, i + 1..both.end, both.end..usize::MAX] {
                    let part = near.start.max(part.start)..near.end.min(part.end);
                    self.lines.find_close(i, part, self.reach, &mut found);
                }
            }
            let first = self.task.bodies.start;
            self.lines.add_self(i, &mut self.task.out[i - first]);
            for partners in found.askew.chunks(S::F64_LANES) {
                self.add(simd, roots, i, partners, &both, false);
            }
            for partners in found.parallel.chunks(S::F64_LANES) {
                self.add(simd, roots, i, partners, &both, true);
            }
        }
    }
}

/// Segments that are close to another: those that are not parallel to it, and those that nearly are.
#[derive(Default)]
struct Partners {
    askew: Vec<usize>,
    parallel: Vec<usize>,
}

impl Lines {
    /// Finds the segments of `range` that are close to `i`.
    #[inline(always)]
    fn find_close(&self, i: usize, range: Range<usize>, reach: f64, found: &mut Partners) {
        let place = [0, 1, 2].map(|c| self.middle[c][i]);
        let half = 0.5 * reach;
        for first in range.clone().step_by(LANES) {
            let chunk = first..range.end.min(first + LANES);
            let [x, y, z] = [0, 1, 2].map(|c| &self.middle[c][chunk.clone()]);
            let length = &self.length[chunk.clone()];
            let mut beyond = [1.0; LANES];
            for k in 0..chunk.len() {
                let d = [x[k] - place[0], y[k] - place[1], z[k] - place[2]];
                let limit = half * (length[k] + self.length[i]);
                beyond[k] = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - limit * limit;
            }
            if beyond.iter().any(|b| *b < 0.0) {
                for (j, _) in chunk.zip(beyond).filter(|(_, beyond)| *beyond < 0.0) {
                    let tangent = |k: usize| Vector3::from_fn(|c, _| self.tangent[c][k]);
                    let sine2: f64 = tangent(i).cross(&tangent(j)).norm_squared();
                    let skew = sine2 >= self.parallel * self.parallel;
                    if skew { &mut found.askew } else { &mut found.parallel }.push(j);
                }
            }
        }
    }
}

impl Close<'_> {
    /// Adds the pairs of `i` and at most as many `partners` as there are lanes.
    #[inline(always)]
    fn add<S: Simd, R: Roots<S>>(
        &mut self,
        simd: S,
        roots: R,
        i: usize,
        partners: &[usize],
        both: &Range<usize>,
        nearly_parallel: bool,
    ) {
        let lines = self.lines;
        // Lanes without a partner repeat the first one without its charge.
        let (mut indices, mut charges) = ([partners[0]; LANES], [0.0; LANES]);
        let mut softening = [SOFTENING; LANES];
        for (k, &j) in partners.iter().enumerate() {
            indices[k] = j;
            charges[k] = lines.charge[i] * lines.charge[j];
            let neighbors = lines.index[i].abs_diff(lines.index[j]) == 1;
            if neighbors && lines.fiber[i] == lines.fiber[j] {
                softening[k] = lines.softening[i];
            }
        }
        let own = lines.gather(simd, &[i; LANES]);
        let others = lines.gather(simd, &indices);
        let softening = Lanes::load(simd, &softening);
        let exact = if nearly_parallel {
            parallel(roots, &own, &others, softening, softening.of(lines.parallel))
        } else {
            skew(roots, &own, &others, softening)
        };
        let difference = exact.less(&as_points(roots, &lines.rule, &own, &others));
        let charges = Lanes::load(simd, &charges);
        let energy = (difference.energy * charges).store();
        let mut forces = [[0.0; LANES]; 9];
        for c in 0..3 {
            forces[c] = (difference.force[c] * charges).store();
            forces[3 + c] = (difference.first_end[c] * charges).store();
            forces[6 + c] = (difference.second_end[c] * charges).store();
        }
        let first = self.task.bodies.start;
        for (k, &j) in partners.iter().enumerate() {
            let own = &mut self.task.out[i - first];
            own[0] += 0.5 * energy[k];
            for c in 0..3 {
                own[1 + c] += forces[c][k] - forces[3 + c][k];
                own[4 + c] += forces[3 + c][k];
            }
            if both.contains(&j) {
                let other = &mut self.task.out[j - first];
                other[0] += 0.5 * energy[k];
                for c in 0..3 {
                    other[1 + c] -= forces[c][k] - forces[6 + c][k];
                    other[4 + c] -= forces[6 + c][k];
                }
            }
        }
    }
}

/// The means over the points of two lines.
#[inline(always)]
fn as_points<S: Simd, R: Roots<S>>(
    roots: R,
    rule: &[[f64; 2]],
    first: &Line<S>,
    second: &Line<S>,
) -> Means<S> {
    let softening = first.length.of(SOFTENING);
    let mut sum = Means::zero(softening.simd);
    for [u, w] in rule {
        let point = along(&first.start, &first.tangent, first.length * softening.of(*u));
        for [v, x] in rule {
            let other = along(&second.start, &second.tangent, second.length * softening.of(*v));
            let r = minus(&point, &other);
            let inverse = roots.inverse_root(dot(&r, &r) + softening);
            let share = inverse * softening.of(w * x);
            let force = scaled(&r, share * (inverse * inverse));
            let pair = Means {
                energy: share,
                force,
                first_end: scaled(&force, softening.of(*u)),
                second_end: scaled(&force, softening.of(*v)),
            };
            sum = sum.plus(&pair, softening.of(1.0));
        }
    }
    sum
}
