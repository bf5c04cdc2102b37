use super::bounds::rounding;
use super::node::{RayNode, WIDTH};
use crate::Ray;
use nalgebra::Point3;
use pulp::Simd;
use rapunzel_lanes::Lane;

/// A ray in the coordinates of a tree, in single precision.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TreeRay {
    /// From the middle of the tree, m.
    pub(crate) origin: [f32; 3],
    pub(crate) direction: [f32; 3],
    /// `1 / direction`, finite, and `-origin / direction`.
    inverse: [f32; 3],
    shift: [f32; 3],
    /// How far from the origin of the ray itself this origin is, m.
    pub(crate) advance: f64,
    /// Where from and how far it goes, m, from this origin.
    start: f32,
    pub(crate) end: f32,
}

impl TreeRay {
    /// The part of a ray between two distances, m, that may meet what is within `extent` of
    /// `middle` along each axis; none if there is none.
    pub(crate) fn new(
        ray: &Ray,
        [start, end]: [f64; 2],
        middle: &Point3<f64>,
        extent: f64,
    ) -> Option<Self> {
        let from = ray.origin - middle;
        let [mut enter, mut leave] = [start, end];
        for d in 0..3 {
            let slope = 1.0 / ray.direction[d];
            let [a, b] = [-extent - from[d], extent - from[d]].map(|x| x * slope);
            // Of a ray along a face both are no numbers, and the face excludes nothing.
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        if enter > leave {
            return None;
        }
        // From where it enters: all that follows is then as small as the tree.
        let advance = enter;
        let origin = single(&(from + advance * ray.direction).into());
        let direction = single(&ray.direction.into());
        let inverse = direction.map(|x| 1.0 / if x.abs() > 1e-12 { x } else { 1e-12 });
        let shift = [0, 1, 2].map(|d| -origin[d] * inverse[d]);
        let rounded = 2.0 * rounding(extent);
        let [start, end] = single(&[start - advance - rounded, leave - advance + rounded]);
        Some(Self { origin, direction, inverse, shift, advance, start, end })
    }

    /// Ends the ray at a distance, m, from the origin of the ray itself.
    #[inline(always)]
    pub(crate) fn shorten(&mut self, distance: f64) {
        // The next single above: what is as near is not lost.
        let [end] = single(&[distance - self.advance]);
        self.end = end + end.abs() * f32::EPSILON;
    }

    /// Where the ray enters the boxes of a node, and which it meets before its end, as bits.
    #[inline(always)]
    pub(super) fn meet<S: Simd, B: SignBits>(
        &self,
        (simd, bits): (S, B),
        node: &RayNode,
        near: &mut [f32; WIDTH],
    ) -> u32 {
        let mut gap = [0.0; WIDTH];
        for register in 0..WIDTH / S::F32_LANES {
            let mut enter = Lane::splat(simd, self.start);
            let mut leave = Lane::splat(simd, self.end);
            for d in 0..3 {
                let inverse = Lane::splat(simd, self.inverse[d]);
                let shift = Lane::splat(simd, self.shift[d]);
                let low = Lane::load(simd, &node.low[d], register);
                let high = Lane::load(simd, &node.high[d], register);
                let (first, second) = if self.inverse[d] > 0.0 { (low, high) } else { (high, low) };
                enter = enter.max(first.mul_add(inverse, shift));
                leave = leave.min(second.mul_add(inverse, shift));
            }
            enter.store(near, register);
            (enter - leave).store(&mut gap, register);
        }
        bits.negative(&gap)
    }
}

/// Rounds coordinates.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "rounding is what it is for")]
pub(crate) fn single<const N: usize>(x: &[f64; N]) -> [f32; N] {
    let mut rounded = [0.0; N];
    for d in 0..N {
        rounded[d] = x[d] as f32;
    }
    rounded
}

/// How signs become bits.
pub(crate) trait SignBits: Copy {
    /// The lanes whose sign is set, as bits.
    fn negative(self, lanes: &[f32; WIDTH]) -> u32;
}

/// Signs number by number.
#[derive(Clone, Copy)]
pub(crate) struct PortableSigns;

impl SignBits for PortableSigns {
    #[inline(always)]
    fn negative(self, lanes: &[f32; WIDTH]) -> u32 {
        let mut bits = 0;
        for lane in 0..WIDTH {
            bits |= (lanes[lane].to_bits() >> 31) << lane;
        }
        bits
    }
}

#[cfg(target_arch = "x86_64")]
impl SignBits for pulp::x86::V3 {
    #[inline(always)]
    fn negative(self, lanes: &[f32; WIDTH]) -> u32 {
        self.avx._mm256_movemask_ps(pulp::cast(*lanes)).cast_unsigned()
    }
}
