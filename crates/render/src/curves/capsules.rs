use super::tube::Tube;
use crate::tree::{RayBox, SignBits, TreeRay, WIDTH, single};
use nalgebra::Vector3;
use pulp::Simd;
use rapunzel_lanes::{Lane, V3};

/// Most parts of a piece, as a power of two.
const FINEST: u32 = 3;
/// Chords are cut until the curve is no farther from them than this many radii.
const SAGITTA: f64 = 8.0;

/// Where a parabola bulges by less than this part of its chord, as a ray sees both, its nearest
/// point is found by one step from that of the chord.
const FLAT: f32 = 0.2;
/// What such a step may leave out, of the bulge.
const UNFOUND: f64 = 2e-4;

/// A part of a piece: piece, place, and number of parts, in one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct CurvePart(u32);

impl CurvePart {
    /// Pieces that can be told apart.
    pub(super) const PIECES: usize = 1 << 27;

    /// All parts of the piece `piece`, a tube.
    pub(super) fn all(piece: u32, tube: &Tube) -> impl Iterator<Item = Self> + use<> {
        let fine = |level: &u32| tube.curve.sagitta(1 << level) <= SAGITTA * tube.widest();
        let level = (0..FINEST).find(fine).unwrap_or(FINEST);
        (0..1 << level).map(move |part| Self(piece << 5 | part << 2 | level))
    }

    /// The part that is a thing in a tree over the boxes of parts.
    pub(super) fn from_thing(thing: u32) -> Self {
        Self(thing)
    }

    /// The piece, by its first control point.
    pub(super) fn piece(self) -> u32 {
        self.0 >> 5
    }

    /// Where it begins on its piece, and how long it is.
    #[inline(always)]
    pub(super) fn range(self) -> [f64; 2] {
        let length = 1.0 / f64::from(1_u32 << (self.0 & 3));
        [f64::from(self.0 >> 2 & 7) * length, length]
    }
}

/// What holds a part: all that is near a parabola.
#[derive(Debug, Clone, Copy)]
pub(super) struct CurveCapsule {
    pub(super) part: CurvePart,
    /// Ends of the axis when the exposure begins, from the middle of the tree, m.
    ends: [Vector3<f64>; 2],
    /// By how much its middle is beside the chord, four times, m: it is at
    /// `chord(a) + a (1 - a) bulge` for `a` in `[0, 1]`.
    bulge: Vector3<f64>,
    /// Ways of the ends and of the bulge during the exposure, m.
    ways: [Vector3<f64>; 3],
    reach: f64,
}

impl CurveCapsule {
    /// The capsule that holds a part of a tube at rest, with `spare`, m, for roundings.
    #[inline(always)]
    pub(super) fn new(part: CurvePart, tube: &Tube, spare: f64) -> Self {
        let [start, length] = part.range();
        let [a, middle, b] = [0.0, 0.5, 1.0].map(|t| tube.curve.at(start + t * length));
        let bulge = 4.0 * middle - 2.0 * (a + b);
        let off = tube.curve.off_parabola(length);
        let reach = tube.widest() + off + UNFOUND * bulge.norm() + spare;
        Self { part, ends: [a, b], bulge, ways: [Vector3::zeros(); 3], reach }
    }

    /// The same if the tube is another when the exposure ends.
    pub(super) fn to(self, tube: &Tube, spare: f64) -> Self {
        let then = Self::new(self.part, tube, spare);
        let [a, b] = [0, 1].map(|k| then.ends[k] - self.ends[k]);
        let ways = [a, b, then.bulge - self.bulge];
        Self { ways, reach: self.reach.max(then.reach), ..self }
    }

    /// The box around it at all times: that of the three control points of the parabola.
    #[inline(always)]
    pub(super) fn bounds(&self) -> RayBox {
        let of = |a: Vector3<f64>, b: Vector3<f64>, bulge: Vector3<f64>| {
            let control = 0.5 * (a + b + bulge);
            [a.inf(&b).inf(&control), a.sup(&b).sup(&control)]
        };
        let ([a, b], [u, v, w]) = (self.ends, self.ways);
        let (now, then) = (of(a, b, self.bulge), of(a + u, b + v, self.bulge + w));
        let reach = Vector3::repeat(self.reach);
        let (low, high) = (now[0].inf(&then[0]) - reach, now[1].sup(&then[1]) + reach);
        RayBox::new(single(&low.into()), single(&high.into()), self.part.0)
    }
}

/// Ways of the capsules of a block: of their first ends, and by how much those of the others
/// differ.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub(super) struct MovingEnds {
    start: [[f32; WIDTH]; 3],
    axis: [[f32; WIDTH]; 3],
    bulge: [[f32; WIDTH]; 3],
}

impl MovingEnds {
    /// No ways.
    pub(super) const REST: Self = {
        let zeros = [[0.0; WIDTH]; 3];
        Self { start: zeros, axis: zeros, bulge: zeros }
    };

    /// Puts the ways of a capsule into a lane.
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, capsule: &CurveCapsule) {
        let [a, b, bulge] = capsule.ways;
        let [start, axis, bulge] = [a, b - a, bulge].map(|way| single(&way.into()));
        for d in 0..3 {
            self.start[d][lane] = start[d];
            self.axis[d][lane] = axis[d];
            self.bulge[d][lane] = bulge[d];
        }
    }
}

/// Eight capsules side by side.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub(super) struct CapsuleBlock {
    start: [[f32; WIDTH]; 3],
    axis: [[f32; WIDTH]; 3],
    bulge: [[f32; WIDTH]; 3],
    /// Negative where there is none.
    reach: [f32; WIDTH],
    parts: [CurvePart; WIDTH],
}

impl CapsuleBlock {
    /// No capsules.
    pub(super) const EMPTY: Self = {
        let zeros = [[0.0; WIDTH]; 3];
        let parts = [CurvePart(0); WIDTH];
        Self { start: zeros, axis: zeros, bulge: zeros, reach: [-1.0; WIDTH], parts }
    };

    /// Puts a capsule into a lane.
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, capsule: &CurveCapsule) {
        let CurveCapsule { part, ends: [a, b], bulge, reach, .. } = *capsule;
        let [start, axis, bulge] = [a, b - a, bulge].map(|v| single(&v.into()));
        for d in 0..3 {
            self.start[d][lane] = start[d];
            self.axis[d][lane] = axis[d];
            self.bulge[d][lane] = bulge[d];
        }
        [self.reach[lane]] = single(&[reach]);
        self.parts[lane] = part;
    }

    /// The part in a lane.
    pub(super) fn part(&self, lane: usize) -> CurvePart {
        self.parts[lane]
    }

    /// Lanes whose capsules the ray comes as near as their reach before its end, as bits, and where
    /// on the axes it is nearest, in `[0, 1]`.
    #[inline(always)]
    pub(super) fn meet<S: Simd, B: SignBits>(
        &self,
        (simd, bits): (S, B),
        ray: &TreeRay,
        across: &[[f32; 3]; 2],
        moving: Option<(&MovingEnds, f32)>,
        nearest: &mut [f32; WIDTH],
    ) -> u32 {
        let mut beyond = [0.0; WIDTH];
        for register in 0..WIDTH / S::F32_LANES {
            let (mut start, mut axis) =
                (load(simd, &self.start, register), load(simd, &self.axis, register));
            let mut bulge = load(simd, &self.bulge, register);
            if let Some((ways, time)) = moving {
                let time = Lane::splat(simd, time);
                start = load(simd, &ways.start, register).mul_add(time, start);
                axis = load(simd, &ways.axis, register).mul_add(time, axis);
                bulge = load(simd, &ways.bulge, register).mul_add(time, bulge);
            }
            let from = start - splat(simd, &ray.origin);
            let reach = Lane::load(simd, &self.reach, register);
            let (zero, one) = (Lane::splat(simd, 0.0), Lane::splat(simd, 1.0));
            // The parabola as the ray sees it, and the point of its chord that is nearest.
            let (right, up) = (splat(simd, &across[0]), splat(simd, &across[1]));
            let (x, y) = (from.dot(right), from.dot(up));
            let (u, v) = (axis.dot(right), axis.dot(up));
            let (b, c) = (bulge.dot(right), bulge.dot(up));
            let length = u.mul_add(u, v * v).max(Lane::splat(simd, f32::MIN_POSITIVE));
            let at = (-x.mul_add(u, y * v) / length).max(zero).min(one);
            let (px, py) = (at.mul_add(u, x), at.mul_add(v, y));
            let to_chord = px.mul_add(px, py * py);
            // From there a step of Gauss and Newton to that of the parabola.
            let (half, slope) = (at * (one - at), one - at - at);
            let (px, py) = (half.mul_add(b, px), half.mul_add(c, py));
            let (dx, dy) = (slope.mul_add(b, u), slope.mul_add(c, v));
            let steep = dx.mul_add(dx, dy * dy).max(Lane::splat(simd, f32::MIN_POSITIVE));
            let at = (at - px.mul_add(dx, py * dy) / steep).max(zero).min(one);
            at.store(nearest, register);
            let half = at * (one - at);
            let (px, py) = (half.mul_add(b, at.mul_add(u, x)), half.mul_add(c, at.mul_add(v, y)));
            let to_curve = px.mul_add(px, py * py);
            // Where the parabola bulges much, it is within a quarter of the bulge of its chord.
            let squared = b.mul_add(b, c * c);
            let flat = squared.less_than(length * Lane::splat(simd, FLAT * FLAT));
            let wide = reach + squared.sqrt() * Lane::splat(simd, 0.25);
            let aside = flat.select(to_curve - reach * reach, to_chord - wide * wide);
            // The capsule begins behind the end of the ray, or ends before its start.
            let sight = splat(simd, &ray.direction);
            let (z, w) = (from.dot(sight), axis.dot(sight));
            let bulged = bulge.dot(sight) * Lane::splat(simd, 0.25);
            let behind = z.min(z + w) + bulged.min(zero) - reach - Lane::splat(simd, ray.end);
            let before = Lane::splat(simd, ray.start) - reach - bulged.max(zero) - z.max(z + w);
            aside.max(behind).max(before).max(-reach).store(&mut beyond, register);
        }
        bits.negative(&beyond)
    }
}

/// A register of vectors.
#[inline(always)]
fn load<S: Simd>(simd: S, all: &[[f32; WIDTH]; 3], register: usize) -> V3<S, f32> {
    let [x, y, z] = all;
    V3([
        Lane::load(simd, x, register),
        Lane::load(simd, y, register),
        Lane::load(simd, z, register),
    ])
}

/// A vector in all lanes.
#[inline(always)]
fn splat<S: Simd>(simd: S, v: &[f32; 3]) -> V3<S, f32> {
    V3([Lane::splat(simd, v[0]), Lane::splat(simd, v[1]), Lane::splat(simd, v[2])])
}
