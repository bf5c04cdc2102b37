//! Segments in motion, in single precision: which pairs of them stay apart, told at little cost.

use super::bounds::above;
use crate::{Capsules, Pair};
use nalgebra::Vector3;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// Lines that one thread takes at a time.
const LINE_CHUNK: usize = 1024;
/// Pairs that are gathered at a time.
const BATCH: usize = 64;
/// Axes that enclose less than this angle are compared as parallels; its squared sine. Where it is
/// larger, a distance of axes is off by less than the part [`LINE_ROUNDING`] of their lengths.
const PARALLEL_WAYS: f32 = 1e-3;
const LINE_ROUNDING: f64 = 1e-4;
/// What may be left of the squared sine of parallels.
const CANCELLED: f32 = 4e-6;
/// Numbers are off by less than this part.
const NUMBER: f64 = 1e-7;

/// A segment on a straight way.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct MovingLine {
    /// At the start (world), m.
    start: [f32; 3],
    /// From there to the other end, m, and the inverse of its squared length.
    axis: [f32; 3],
    inverse: f32,
    /// The way of the middle, m.
    way: [f32; 3],
    /// How far a point may go beyond the way of the middle and half of a reach, m, with all
    /// roundings.
    own: f32,
}

impl MovingLine {
    const NONE: Self =
        Self { start: [0.0; 3], axis: [0.0; 3], inverse: 0.0, way: [0.0; 3], own: 0.0 };
}

/// Replaces `lines` by all segments on their ways from `start` to `end`, where to be within
/// `reach`, m, of each other counts.
pub(super) fn take_lines(
    start: &Capsules,
    end: &Capsules,
    reach: f64,
    lines: &mut Vec<MovingLine>,
) {
    lines.resize(start.len(), MovingLine::NONE);
    lines.par_chunks_mut(LINE_CHUNK).enumerate().for_each(|(chunk, lines)| {
        Arch::new().dispatch(TakeLines { start, end, reach, first: chunk * LINE_CHUNK, lines });
    });
}

/// Takes the lines of some segments in a row.
struct TakeLines<'a> {
    start: &'a Capsules<'a>,
    end: &'a Capsules<'a>,
    reach: f64,
    first: usize,
    lines: &'a mut [MovingLine],
}

impl NullaryFnOnce for TakeLines<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { start, end, reach, first, lines } = self;
        for (segment, line) in (first..).zip(lines) {
            let [i, j] = start.layout().segment_nodes(segment);
            let (p, q) = (start.positions()[i], start.positions()[j]);
            let (a, b) = (end.positions()[i] - p, end.positions()[j] - q);
            let (axis, way) = (q - p, 0.5 * (a + b));
            let own = 0.5 * (a - b).norm() + start.radii()[segment] + 0.5 * reach;
            let largest = p.coords.norm() + way.norm();
            let roundings = LINE_ROUNDING * axis.norm() + 4.0 * NUMBER * largest;
            *line = MovingLine {
                start: single(&p.coords),
                axis: single(&axis),
                inverse: above(1.0 / axis.norm_squared()),
                way: single(&way),
                own: above((own + roundings) * (1.0 + 4.0 * NUMBER)),
            };
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "rounding is what it is for")]
fn single(x: &Vector3<f64>) -> [f32; 3] {
    (*x).map(|x| x as f32).into()
}

/// Drops pairs of segments that stay apart all the way. Cost: 20 ns a pair, most of it to gather
/// them.
pub(super) fn sift(lines: &[MovingLine], pairs: &mut Vec<Pair>) {
    let kept = Arch::new().dispatch(Sift { lines, pairs });
    pairs.truncate(kept);
}

/// Moves the pairs that are kept to the front, and counts them.
struct Sift<'a> {
    lines: &'a [MovingLine],
    pairs: &'a mut [Pair],
}

impl NullaryFnOnce for Sift<'_> {
    type Output = usize;

    #[inline(always)]
    fn call(self) -> usize {
        let Self { lines, pairs } = self;
        let mut batch = LineBatch::default();
        let mut kept = 0;
        for first in (0..pairs.len()).step_by(BATCH) {
            let count = BATCH.min(pairs.len() - first);
            batch.gather(lines, &pairs[first..first + count]);
            batch.compare();
            for k in 0..count {
                pairs[kept] = pairs[first + k];
                // What has overflowed is no number, and kept.
                let apart = batch.beyond[k] > 0.0;
                kept += usize::from(!apart);
            }
        }
        kept
    }
}

/// The lines of a batch of pairs: axes, from the start of the first to that of the second, from the
/// way of the first to that of the second.
struct LineBatch {
    first: [[f32; BATCH]; 3],
    second: [[f32; BATCH]; 3],
    between: [[f32; BATCH]; 3],
    way: [[f32; BATCH]; 3],
    /// Inverse squares of the axes.
    inverse: [[f32; BATCH]; 2],
    own: [f32; BATCH],
    /// Positive where they stay apart.
    beyond: [f32; BATCH],
}

impl Default for LineBatch {
    fn default() -> Self {
        let (zeros, zero) = ([[0.0; BATCH]; 3], [0.0; BATCH]);
        let (first, second, between, way) = (zeros, zeros, zeros, zeros);
        Self { first, second, between, way, inverse: [zero; 2], own: zero, beyond: zero }
    }
}

impl LineBatch {
    #[inline(always)]
    fn gather(&mut self, lines: &[MovingLine], pairs: &[Pair]) {
        for (k, pair) in pairs.iter().enumerate() {
            let [a, b] = pair.map(|segment| &lines[segment as usize]);
            for d in 0..3 {
                self.first[d][k] = a.axis[d];
                self.second[d][k] = b.axis[d];
                self.between[d][k] = b.start[d] - a.start[d];
                self.way[d][k] = b.way[d] - a.way[d];
            }
            self.inverse[0][k] = a.inverse;
            self.inverse[1][k] = b.inverse;
            self.own[k] = a.own + b.own;
        }
    }

    /// Compares distances at the start with the ways. Parallels are as far apart as their lines,
    /// but for how far the second goes aside.
    #[inline(always)]
    fn compare(&mut self) {
        for k in 0..BATCH {
            let u = [self.first[0][k], self.first[1][k], self.first[2][k]];
            let v = [self.second[0][k], self.second[1][k], self.second[2][k]];
            let r = [self.between[0][k], self.between[1][k], self.between[2][k]];
            let s = [self.way[0][k], self.way[1][k], self.way[2][k]];
            let (a, b, c, e, f) = (dot(&u, &u), dot(&u, &v), dot(&u, &r), dot(&v, &v), dot(&v, &r));
            let (per_a, per_e) = (self.inverse[0][k], self.inverse[1][k]);
            let determinant = a * e - b * b;
            let oblique = determinant > PARALLEL_WAYS * a * e;
            let at = clamped((c * e - b * f) / determinant);
            let t = clamped((at * b - f) * per_e);
            let at = clamped((c + t * b) * per_a);
            let x = r[0] + t * v[0] - at * u[0];
            let y = r[1] + t * v[1] - at * u[1];
            let z = r[2] + t * v[2] - at * u[2];
            let of_lines = dot(&r, &r) - c * c * per_a;
            let squared = if oblique { x * x + y * y + z * z } else { of_lines };
            let aside = if oblique { 0.0 } else { determinant.abs() * per_a + CANCELLED * e };
            let reach = dot(&s, &s).sqrt() + aside.sqrt() + self.own[k];
            self.beyond[k] = squared - reach * reach;
        }
    }
}

#[inline(always)]
fn dot(p: &[f32; 3], q: &[f32; 3]) -> f32 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

/// `x` moved into 0..=1.
#[inline(always)]
fn clamped(x: f32) -> f32 {
    let x = if x > 0.0 { x } else { 0.0 };
    if x < 1.0 { x } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;
    use proptest::prelude::*;
    use rapunzel_fiber::Layout;

    const RADIUS: f64 = 0.01;

    /// Coordinates that often coincide, so that axes are parallel, nearly so, or points; some far
    /// away.
    fn ends() -> impl Strategy<Value = [[f64; 3]; 4]> {
        let x = || prop_oneof![(-2..=2_i8).prop_map(f64::from), -2.0..2.0_f64, -1e-3..1e-3_f64];
        (prop::array::uniform4(prop::array::uniform3(x())), prop_oneof![Just(0.0), Just(1e3)])
            .prop_map(|(ends, far)| ends.map(|end| end.map(|x| x + far)))
    }

    /// Whether two segments that move on straight ways are kept.
    fn kept(start: &[Point3<f64>], end: &[Point3<f64>], reach: f64) -> bool {
        let layout = Layout::new([1, 1]);
        let [start, end] =
            [start, end].map(|x| Capsules::new(&layout, x, &[RADIUS; 2]).expect("valid"));
        let mut pairs = vec![[0, 1]];
        let mut lines = Vec::new();
        take_lines(&start, &end, reach, &mut lines);
        sift(&lines, &mut pairs);
        !pairs.is_empty()
    }

    proptest! {
        #[test]
        fn what_comes_near_is_kept(
            start in ends(),
            ways in prop::array::uniform4(prop::array::uniform3(-1.0..1.0_f64)),
            size in prop_oneof![Just(0.0), 0.0..1.0_f64],
            reach in 0.0..0.5_f64,
        ) {
            let start = start.map(Point3::from);
            let end = [0, 1, 2, 3].map(|i| start[i] + Vector3::from(ways[i]) * size);
            let layout = Layout::new([1, 1]);
            let near = |part: f64| {
                let now = [0, 1, 2, 3].map(|i| start[i] + (end[i] - start[i]) * part);
                let now = Capsules::new(&layout, &now, &[RADIUS; 2]).expect("valid");
                now.get(0).closest(&now.get(1)).distance() <= 2.0 * RADIUS + reach
            };
            let near = [0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0].into_iter().any(near);
            prop_assert!(!near || kept(&start, &end, reach));
        }
    }

    #[test]
    fn what_stays_apart_is_dropped() {
        let at = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
        for (tip, reach, expected) in [
            // Crossed, parallel, and nearly so, an eighth above each other.
            (at(0.0, 1.0, 0.125), 0.09, false),
            (at(0.0, 1.0, 0.125), 0.11, true),
            (at(1.0, 0.0, 0.125), 0.09, false),
            (at(1.0, 0.0, 0.125), 0.11, true),
            (at(1.0, 0.001, 0.125), 0.07, false),
        ] {
            let first = [at(-1.0, 0.0, 0.0), at(1.0, 0.0, 0.0)];
            let second = [at(-tip.x, -tip.y, tip.z), tip];
            let start = [first, second].concat();
            assert_eq!(kept(&start, &start, reach), expected, "{tip} {reach}");
            // What goes along with it stays as far.
            let moved: Vec<_> = start.iter().map(|x| x + Vector3::new(3.0, 2.0, 1.0)).collect();
            assert_eq!(kept(&start, &moved, reach), expected, "{tip} {reach}");
        }
    }
}
