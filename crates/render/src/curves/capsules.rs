use super::tube::Tube;
use crate::tree::{LeafThings, NONE, RayBox, SignBits, TreeRay, WIDTH, single};
use nalgebra::Vector3;
use pulp::Simd;
use rapunzel_lanes::{Lane, V3};

/// Most parts of a piece, as a power of two.
const FINEST: u32 = 3;
/// Chords are cut until the curve is no farther from them than this many radii.
const SAGITTA: f64 = 4.0;

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

/// The straight capsule around a part.
#[derive(Debug, Clone, Copy)]
pub(super) struct CurveCapsule {
    pub(super) part: CurvePart,
    /// Ends of the axis when the exposure begins, from the middle of the tree, m.
    ends: [Vector3<f64>; 2],
    /// Their ways, m.
    ways: [Vector3<f64>; 2],
    reach: f64,
}

impl CurveCapsule {
    /// The capsule that holds a part of a tube at all times between two, at which it is given, with
    /// `spare`, m, for roundings.
    pub(super) fn new(part: CurvePart, tubes: &[Tube; 2], spare: f64) -> Self {
        let [start, length] = part.range();
        let [ends, then] =
            [0, 1].map(|k: usize| [start, start + length].map(|t| tubes[k].curve.at(t)));
        let of = |tube: &Tube| tube.widest() + tube.curve.sagitta(1 << (part.0 & 3));
        let reach = of(&tubes[0]).max(of(&tubes[1])) + spare;
        Self { part, ends, ways: [then[0] - ends[0], then[1] - ends[1]], reach }
    }

    /// The box around it at all times.
    pub(super) fn bounds(&self) -> RayBox {
        let [a, b] = &self.ends;
        let [c, d] = [a + self.ways[0], b + self.ways[1]];
        let reach = Vector3::repeat(self.reach);
        let low = a.inf(b).inf(&c).inf(&d) - reach;
        let high = a.sup(b).sup(&c).sup(&d) + reach;
        RayBox::new(single(&low.into()), single(&high.into()))
    }
}

/// Ways of the capsules of a block: of their first ends, and by how much those of the others
/// differ.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub(super) struct MovingEnds {
    start: [[f32; WIDTH]; 3],
    axis: [[f32; WIDTH]; 3],
}

impl MovingEnds {
    /// The ways in a leaf.
    pub(super) fn new(leaf: &LeafThings, capsule: impl Fn(u32) -> CurveCapsule) -> Self {
        let mut ways = Self { start: [[0.0; WIDTH]; 3], axis: [[0.0; WIDTH]; 3] };
        for (lane, &index) in leaf.iter().enumerate().filter(|(_, index)| **index != NONE) {
            let [a, b] = capsule(index).ways;
            let (start, axis): ([f32; 3], [f32; 3]) = (single(&a.into()), single(&(b - a).into()));
            for d in 0..3 {
                ways.start[d][lane] = start[d];
                ways.axis[d][lane] = axis[d];
            }
        }
        ways
    }
}

/// Eight capsules side by side.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub(super) struct CapsuleBlock {
    start: [[f32; WIDTH]; 3],
    axis: [[f32; WIDTH]; 3],
    /// Negative where there is none.
    reach: [f32; WIDTH],
    parts: [CurvePart; WIDTH],
}

impl CapsuleBlock {
    /// The capsules of a leaf.
    pub(super) fn new(leaf: &LeafThings, capsule: impl Fn(u32) -> CurveCapsule) -> Self {
        let zeros = [[0.0; WIDTH]; 3];
        let parts = [CurvePart(0); WIDTH];
        let mut block = Self { start: zeros, axis: zeros, reach: [-1.0; WIDTH], parts };
        for (lane, &index) in leaf.iter().enumerate().filter(|(_, index)| **index != NONE) {
            let CurveCapsule { part, ends: [a, b], reach, .. } = capsule(index);
            let (start, axis) = (single(&a.into()), single(&(b - a).into()));
            for d in 0..3 {
                block.start[d][lane] = start[d];
                block.axis[d][lane] = axis[d];
            }
            [block.reach[lane]] = single(&[reach]);
            block.parts[lane] = part;
        }
        block
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
            if let Some((ways, time)) = moving {
                let time = Lane::splat(simd, time);
                start = load(simd, &ways.start, register).mul_add(time, start);
                axis = load(simd, &ways.axis, register).mul_add(time, axis);
            }
            let from = start - splat(simd, &ray.origin);
            let reach = Lane::load(simd, &self.reach, register);
            // The axis as the ray sees it, and the point of it that is nearest to the ray.
            let (right, up) = (splat(simd, &across[0]), splat(simd, &across[1]));
            let (x, y) = (from.dot(right), from.dot(up));
            let (u, v) = (axis.dot(right), axis.dot(up));
            let (zero, one) = (Lane::splat(simd, 0.0), Lane::splat(simd, 1.0));
            let length = u.mul_add(u, v * v).max(Lane::splat(simd, f32::MIN_POSITIVE));
            let at = -x.mul_add(u, y * v) / length;
            let at = at.max(zero).min(one);
            at.store(nearest, register);
            let (x, y) = (at.mul_add(u, x), at.mul_add(v, y));
            let aside = x.mul_add(x, y * y) - reach * reach;
            // The capsule begins behind the end of the ray.
            let sight = splat(simd, &ray.direction);
            let (z, w) = (from.dot(sight), axis.dot(sight));
            let behind = z.min(z + w) - reach - Lane::splat(simd, ray.end);
            aside.max(behind).max(-reach).store(&mut beyond, register);
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
