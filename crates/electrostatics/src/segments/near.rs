//! The closed-form sums over pairs of segments that are near each other.

use super::line::{Action, LANES, Lanes, Line, Vectors, act};
use crate::quadrature::gauss_legendre;
use nalgebra::{Point3, Vector3};
use pulp::{Arch, NullaryFnOnce};
use std::ops::Range;

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
    fn broadcast(&self, i: usize) -> Line {
        let mut line = self.gather(i..i + 1);
        for c in 0..3 {
            line.start[c] = [line.start[c][0]; LANES];
            line.tangent[c] = [line.tangent[c][0]; LANES];
        }
        line.length = [line.length[0]; LANES];
        line
    }

    /// At most eight lines; lanes without one hold a line that is far away in units of its length.
    #[inline(always)]
    fn gather(&self, range: Range<usize>) -> Line {
        let mut line =
            Line { start: [[1e30; LANES]; 3], tangent: [[0.0; LANES]; 3], length: [1.0; LANES] };
        let n = range.len();
        for c in 0..3 {
            line.start[c][..n].copy_from_slice(&self.start[c][range.clone()]);
            line.tangent[c][..n].copy_from_slice(&self.tangent[c][range.clone()]);
        }
        line.length[..n].copy_from_slice(&self.length[range]);
        line
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

impl NullaryFnOnce for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { lines, i, near, loads } = self;
        let own = lines.broadcast(i);
        let softening = [CLOSEST * CLOSEST; LANES];
        let mut sums = [[0.0; LANES]; 7];
        for range in near {
            for first in range.clone().step_by(LANES) {
                let chunk = first..range.end.min(first + LANES);
                let mut charge = [0.0; LANES];
                for (k, j) in chunk.clone().enumerate() {
                    let same = lines.fiber[j] == lines.fiber[i];
                    let joint = same && lines.index[j].abs_diff(lines.index[i]) <= 1;
                    charge[k] = if joint { 0.0 } else { lines.charge[j] };
                    if joint && j == i {
                        lines.add_self(i, loads);
                    } else if joint {
                        joint_pair(lines, i, j, loads);
                    }
                }
                let line = lines.gather(chunk);
                add_pairs([&own, &line], &lines.rule, &charge, &softening, &mut sums);
            }
        }
        for (load, sum) in loads.iter_mut().zip(&sums) {
            *load += lines.charge[i] * sum.iter().sum::<f64>();
        }
    }
}

/// Segments `i` and `j` that share a node.
#[inline(always)]
fn joint_pair(lines: &Lines, i: usize, j: usize, loads: &mut Loads) {
    let [own, other] = [lines.broadcast(i), lines.gather(j..j + 1)];
    let mut charge = [0.0; LANES];
    charge[0] = lines.charge[j];
    // Where j follows i, the joint is the end of i and the start of j.
    let follows = lines.index[j] > lines.index[i];
    let turned = |[u, w]: &[f64; 2], turn: bool| [if turn { 1.0 - u } else { *u }, *w];
    let softening = [lines.softening[i]; LANES];
    let mut sums = [[0.0; LANES]; 7];
    for node in &lines.joint_rule {
        add_pair([&own, &other], turned(node, follows), true, &charge, &softening, &mut sums);
        add_pair([&own, &other], turned(node, !follows), false, &charge, &softening, &mut sums);
    }
    for (load, sum) in loads.iter_mut().zip(&sums) {
        *load += lines.charge[i] * sum.iter().sum::<f64>();
    }
}

/// Half of what the points of one segment do with the other lines, and half of what the points of
/// those do with the one line.
#[inline(always)]
fn add_pairs(
    lines: [&Line; 2],
    rule: &[[f64; 2]],
    charge: &Lanes,
    softening: &Lanes,
    sums: &mut [Lanes; 7],
) {
    for node in rule {
        add_pair(lines, *node, true, charge, softening, sums);
        add_pair(lines, *node, false, charge, softening, sums);
    }
}

/// The share of one point: of the own segment (`mine`), or of each other one.
#[inline(always)]
fn add_pair(
    [own, other]: [&Line; 2],
    [u, w]: [f64; 2],
    mine: bool,
    charge: &Lanes,
    softening: &Lanes,
    sums: &mut [Lanes; 7],
) {
    let (from, line) = if mine { (own, other) } else { (other, own) };
    let point = at(from, u);
    let Action { energy, point, end } = act(&point, line, softening);
    for k in 0..LANES {
        let q = 0.5 * w * charge[k];
        if mine {
            sums[0][k] += q * energy[k];
        }
        for c in 0..3 {
            let (start, end) = if mine {
                ((1.0 - u) * point[c][k], u * point[c][k])
            } else {
                (-point[c][k] - end[c][k], end[c][k])
            };
            sums[1 + c][k] += q * start;
            sums[4 + c][k] += q * end;
        }
    }
}

/// The points at the share `u` of the lines.
#[inline(always)]
fn at(line: &Line, u: f64) -> Vectors {
    let mut point = line.start;
    for c in 0..3 {
        for k in 0..LANES {
            point[c][k] += u * line.length[k] * line.tangent[c][k];
        }
    }
    point
}

/// The points of the rule with `count` points on a segment, and their shares of its charge.
pub(super) fn points(
    rule: &[[f64; 2]],
    [start, end]: [Point3<f64>; 2],
) -> impl Iterator<Item = (Vector3<f64>, f64)> {
    rule.iter().map(move |[x, w]| ((start.coords * (1.0 - x) + end.coords * (1.0 + x)) * 0.5, 0.5 * w))
}
