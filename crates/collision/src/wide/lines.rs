//! Segments in motion, sixteen side by side: which of them stay apart, told without gathering them.

use super::bounds::above;
use super::{NONE, Tree, WIDTH};
use crate::Capsules;
use rayon::prelude::*;

/// Blocks that one thread fits at a time.
const CHUNK: usize = 64;
/// Axes that enclose less than this angle are not told apart; its squared sine. Where it is larger,
/// a distance of axes is off by less than the part [`ROUNDING`] of their lengths.
const PARALLEL: f32 = 1e-3;
const ROUNDING: f64 = 1e-4;
/// Coordinates are off by less than this part.
const COORDINATE: f64 = 1e-7;

/// The segments of a block of the lowest level on straight ways, in single precision.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Lines {
    /// At the start (world), m.
    start: [[f32; WIDTH]; 3],
    /// From there to the other end, m, and the inverse of its square.
    axis: [[f32; WIDTH]; 3],
    inverse: [f32; WIDTH],
    /// The way of the middle, m.
    way: [[f32; WIDTH]; 3],
    /// How far a point may go beyond the way of the middle and half of the reach, m, with all
    /// roundings.
    own: [f32; WIDTH],
}

impl Lines {
    const EMPTY: Self = Self {
        start: [[0.0; WIDTH]; 3],
        axis: [[0.0; WIDTH]; 3],
        inverse: [0.0; WIDTH],
        way: [[0.0; WIDTH]; 3],
        own: [0.0; WIDTH],
    };

    /// Tells by positive numbers which segments stay out of reach of the one in the `lane` of other
    /// lines all the way.
    #[inline(always)]
    pub(super) fn apart(&self, other: &Self, lane: usize) -> [f32; WIDTH] {
        let [p, u, w] = [&other.start, &other.axis, &other.way].map(|x| x.map(|x| x[lane]));
        let (own, per_a) = (other.own[lane], other.inverse[lane]);
        let a = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
        let mut apart = [0.0; WIDTH];
        for k in 0..WIDTH {
            let [r, v, s] = [(&self.start, &p), (&self.axis, &[0.0; 3]), (&self.way, &w)]
                .map(|(x, from)| [x[0][k] - from[0], x[1][k] - from[1], x[2][k] - from[2]]);
            let dot = |x: &[f32; 3], y: &[f32; 3]| x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
            let (b, c, e, f) = (dot(&u, &v), dot(&u, &r), dot(&v, &v), dot(&v, &r));
            let determinant = a * e - b * b;
            let oblique = determinant - PARALLEL * a * e;
            let at = clamped((c * e - b * f) / determinant);
            let t = clamped((at * b - f) * self.inverse[k]);
            let at = clamped((c + t * b) * per_a);
            let [x, y, z] = [0, 1, 2].map(|d| r[d] + t * v[d] - at * u[d]);
            // The distance is above own + |s| where its square is so far above both squares.
            let (own, way) = (own + self.own[k], dot(&s, &s));
            let above = x * x + y * y + z * z - own * own - way;
            let beyond = above * above - 4.0 * own * own * way;
            // Numbers that have overflowed tell nothing.
            apart[k] = if oblique > 0.0 && above > 0.0 { beyond } else { 0.0 };
        }
        apart
    }
}

/// `x` moved into 0..=1.
#[inline(always)]
fn clamped(x: f32) -> f32 {
    let x = if x > 0.0 { x } else { 0.0 };
    if x < 1.0 { x } else { 1.0 }
}

impl Tree {
    /// The segments on their ways from `start` to `end`, where to be within `reach`, m, of each other
    /// counts.
    pub(super) fn lines(
        &self,
        start: &Capsules,
        end: &Capsules,
        reach: f64,
        lines: &mut Vec<Lines>,
    ) {
        let blocks = &self.levels[0].children;
        lines.resize(blocks.len(), Lines::EMPTY);
        let lanes = blocks.par_chunks(CHUNK).zip(self.nodes.par_chunks(CHUNK));
        lines.par_chunks_mut(CHUNK).zip(lanes).for_each(|(lines, (blocks, nodes))| {
            for (lines, (segments, nodes)) in lines.iter_mut().zip(blocks.iter().zip(nodes)) {
                for (lane, (&segment, &node)) in segments.iter().zip(nodes).enumerate() {
                    if segment == NONE {
                        continue;
                    }
                    let node = node as usize;
                    let (p, q) = (start.positions()[node], start.positions()[node + 1]);
                    let ways = [end.positions()[node] - p, end.positions()[node + 1] - q];
                    let (axis, way) = (q - p, 0.5 * (ways[0] + ways[1]));
                    let roundings = COORDINATE * (p.coords.amax() + way.amax());
                    let own = 0.5 * (ways[0] - ways[1]).norm()
                        + start.radii()[segment as usize]
                        + 0.5 * reach
                        + ROUNDING * axis.norm()
                        + 4.0 * roundings;
                    for d in 0..3 {
                        lines.start[d][lane] = single(p[d]);
                        lines.axis[d][lane] = single(axis[d]);
                        lines.way[d][lane] = single(way[d]);
                    }
                    lines.inverse[lane] = single(1.0 / axis.norm_squared());
                    lines.own[lane] = above(own * (1.0 + COORDINATE));
                }
            }
        });
    }
}

#[expect(clippy::cast_possible_truncation, reason = "rounding is what it is for")]
fn single(x: f64) -> f32 {
    x as f32
}
