//! The closed-form sums over pairs of segments that are near each other.

use super::line::{Action, Line, Vectors, act};
use crate::quadrature::gauss_legendre;
use nalgebra::{Point3, Vector3};
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Most lanes of any register.
const LANES: usize = 8;

/// Length that no two segments are taken to be closer than, m: it keeps intersecting lines finite and
/// changes the force between touching hairs by 1e-10.
const CLOSEST: f64 = 1e-9;

/// Points on a segment for the pair that it forms with its neighbor, whose force is singular but for
/// the radius: crowded toward the joint as the cube of equidistant ones.
const JOINT_POINTS: usize = 12;

/// Segments in the order of a tree, coordinate by coordinate.
pub(super) struct Lines {
    start: [Vec<f64>; 3],
    tangent: [Vec<f64>; 3],
    length: Vec<f64>,
    charge: Vec<f64>,
    /// Square of the radius.
    softening: Vec<f64>,
    fiber: Vec<u32>,
    /// Index of the segment as it was given.
    index: Vec<u32>,
    rule: Vec<[f64; 2]>,
    joint_rule: Vec<[f64; 2]>,
}

/// Energy, force on the start and force on the end of one segment, without Coulomb's constant.
pub(super) type Loads = [f64; 7];

impl Lines {
    /// Segments are added by [`push`](Self::push); `points` is the number of points of the rule.
    pub(super) fn new(points: usize) -> Self {
        // On [0, 1].
        let unit = |[x, w]: [f64; 2]| [0.5 + 0.5 * x, 0.5 * w];
        let cube = |[x, w]: [f64; 2]| [x * x * x, 3.0 * x * x * w];
        Self {
            start: Default::default(),
            tangent: Default::default(),
            length: Vec::new(),
            charge: Vec::new(),
            softening: Vec::new(),
            fiber: Vec::new(),
            index: Vec::new(),
            rule: gauss_legendre(points).into_iter().map(unit).collect(),
            joint_rule: gauss_legendre(JOINT_POINTS).into_iter().map(unit).map(cube).collect(),
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
        }
        self.length.push(length);
        self.charge.push(charge);
        self.softening.push(radius * radius);
        self.fiber.push(fiber);
        self.index.push(index);
    }

    /// Adds the loads of the segment `i` by itself and by the segments of `near`, half of each pair's.
    pub(super) fn add(&self, i: usize, near: &[Range<usize>], loads: &mut Loads) {
        Arch::new().dispatch(Add { lines: self, i, near, loads });
    }

    #[inline(always)]
    fn broadcast<S: Simd>(&self, simd: S, i: usize) -> Line<S> {
        let mut line = Line {
            start: [simd.splat_f64s(0.0); 3],
            tangent: [simd.splat_f64s(0.0); 3],
            length: simd.splat_f64s(self.length[i]),
        };
        for c in 0..3 {
            line.start[c] = simd.splat_f64s(self.start[c][i]);
            line.tangent[c] = simd.splat_f64s(self.tangent[c][i]);
        }
        line
    }

    /// The lines of `range`, one in each lane; lanes without one hold a line of length 1 far away.
    #[inline(always)]
    fn gather<S: Simd>(&self, range: Range<usize>) -> Line<S> {
        let start = |c: usize| -> &[f64] { &self.start[c][range.clone()] };
        let tangent = |c: usize| -> &[f64] { &self.tangent[c][range.clone()] };
        Line {
            start: [pad::<S>(start(0), 1e30), pad::<S>(start(1), 1e30), pad::<S>(start(2), 1e30)],
            tangent: [
                pad::<S>(tangent(0), 0.0),
                pad::<S>(tangent(1), 0.0),
                pad::<S>(tangent(2), 0.0),
            ],
            length: pad::<S>(&self.length[range.clone()], 1.0),
        }
    }

    /// Energy and tension of a segment by itself: `q^2/L^2 (L asinh(L/a) - sqrt(L^2+a^2) + a)`.
    fn add_self(&self, i: usize, loads: &mut Loads) {
        let (length, a2) = (self.length[i], self.softening[i]);
        let (a, q) = (a2.sqrt(), self.charge[i] / length);
        let slope = (length / a).asinh();
        let g = length * slope - (length * length + a2).sqrt() + a;
        loads[0] += q * q * g;
        let push = q * q * (2.0 * g / length - slope);
        for c in 0..3 {
            loads[1 + c] -= push * self.tangent[c][i];
            loads[4 + c] += push * self.tangent[c][i];
        }
    }
}

struct Add<'a> {
    lines: &'a Lines,
    i: usize,
    near: &'a [Range<usize>],
    loads: &'a mut Loads,
}

/// Values in the first lanes, `rest` in the others.
#[inline(always)]
fn pad<S: Simd>(values: &[f64], rest: f64) -> S::f64s {
    let mut lanes = [rest; LANES];
    lanes[..values.len()].copy_from_slice(values);
    S::as_simd_f64s(&lanes).0[0]
}

impl WithSimd for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { lines, i, near, loads } = self;
        let own = lines.broadcast(simd, i);
        let softening = simd.splat_f64s(CLOSEST * CLOSEST);
        let mut sums = [simd.splat_f64s(0.0); 7];
        for range in near {
            for first in range.clone().step_by(S::F64_LANES) {
                let chunk = first..range.end.min(first + S::F64_LANES);
                let mut charge = [0.0; LANES];
                for (k, j) in chunk.clone().enumerate() {
                    let same = lines.fiber[j] == lines.fiber[i];
                    let joint = same && lines.index[j].abs_diff(lines.index[i]) <= 1;
                    charge[k] = if joint { 0.0 } else { lines.charge[j] };
                    if joint && j == i {
                        lines.add_self(i, loads);
                    } else if joint {
                        let joint = Joint { lines, i, j };
                        joint.add(simd, &own, &mut sums);
                    }
                }
                let line = lines.gather::<S>(chunk);
                let charge = S::as_simd_f64s(&charge).0[0];
                for node in &lines.rule {
                    add_pair(simd, [&own, &line], *node, true, [charge, softening], &mut sums);
                    add_pair(simd, [&own, &line], *node, false, [charge, softening], &mut sums);
                }
            }
        }
        for (load, sum) in loads.iter_mut().zip(&sums) {
            *load += lines.charge[i] * simd.reduce_sum_f64s(*sum);
        }
    }
}

/// Segments that share a node.
struct Joint<'a> {
    lines: &'a Lines,
    i: usize,
    j: usize,
}

impl Joint<'_> {
    #[inline(always)]
    fn add<S: Simd>(&self, simd: S, own: &Line<S>, sums: &mut [S::f64s; 7]) {
        let Self { lines, i, j } = *self;
        let other = lines.gather::<S>(j..j + 1);
        let softening = simd.splat_f64s(lines.softening[i]);
        let weights = [pad::<S>(&[lines.charge[j]], 0.0), softening];
        // Where j follows i, the joint is the end of i and the start of j.
        let follows = lines.index[j] > lines.index[i];
        for [u, w] in &lines.joint_rule {
            let [near_start, near_end] = [[*u, *w], [1.0 - *u, *w]];
            let [mine, theirs] =
                if follows { [near_end, near_start] } else { [near_start, near_end] };
            add_pair(simd, [own, &other], mine, true, weights, sums);
            add_pair(simd, [own, &other], theirs, false, weights, sums);
        }
    }
}

/// Half of what one point of the own segment (`mine`) does with the other lines, or one point on each
/// of those with the own line. `weights` are the charges of the others and the softening.
#[inline(always)]
fn add_pair<S: Simd>(
    simd: S,
    [own, other]: [&Line<S>; 2],
    [u, w]: [f64; 2],
    mine: bool,
    [charge, softening]: [S::f64s; 2],
    sums: &mut [S::f64s; 7],
) {
    let (from, line) = if mine { (own, other) } else { (other, own) };
    let point = at(simd, from, u);
    let Action { energy, point, end } = act(simd, &point, line, softening);
    let q = simd.mul_f64s(simd.splat_f64s(0.5 * w), charge);
    if mine {
        sums[0] = simd.mul_add_e_f64s(q, energy, sums[0]);
        let [before, after] =
            [simd.mul_f64s(simd.splat_f64s(1.0 - u), q), simd.mul_f64s(simd.splat_f64s(u), q)];
        for c in 0..3 {
            sums[1 + c] = simd.mul_add_e_f64s(before, point[c], sums[1 + c]);
            sums[4 + c] = simd.mul_add_e_f64s(after, point[c], sums[4 + c]);
        }
    } else {
        for c in 0..3 {
            let start = simd.add_f64s(point[c], end[c]);
            sums[1 + c] = simd.negate_mul_add_e_f64s(q, start, sums[1 + c]);
            sums[4 + c] = simd.mul_add_e_f64s(q, end[c], sums[4 + c]);
        }
    }
}

/// The points at the share `u` of the lines.
#[inline(always)]
fn at<S: Simd>(simd: S, line: &Line<S>, u: f64) -> Vectors<S> {
    let mut point = line.start;
    let along = simd.mul_f64s(simd.splat_f64s(u), line.length);
    for c in 0..3 {
        point[c] = simd.mul_add_e_f64s(along, line.tangent[c], point[c]);
    }
    point
}

/// The points of the rule with `count` points on a segment, and their shares of its charge.
pub(super) fn points(
    rule: &[[f64; 2]],
    [start, end]: [Point3<f64>; 2],
) -> impl Iterator<Item = (Vector3<f64>, f64)> {
    rule.iter()
        .map(move |[x, w]| ((start.coords * (1.0 - x) + end.coords * (1.0 + x)) * 0.5, 0.5 * w))
}
