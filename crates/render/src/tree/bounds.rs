use pulp::Simd;
use rapunzel_lanes::Lane;

/// A box in single precision, m, from the middle of a tree.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(32))]
pub(crate) struct RayBox {
    /// The lowest coordinates, negated, and the highest, so that a box grows by maxima alone. What
    /// lies behind either fills the register; the last is the index of what is in the box.
    faces: [f32; 8],
}

impl RayBox {
    /// The box that holds nothing.
    pub(crate) const EMPTY: Self = Self { faces: [f32::NEG_INFINITY; 8] };

    /// The box of two corners around the thing of an index.
    #[inline(always)]
    pub(crate) fn new(low: [f32; 3], high: [f32; 3], index: u32) -> Self {
        let ([a, b, c], [x, y, z]) = (low, high);
        Self { faces: [-a, -b, -c, 0.0, x, y, z, f32::from_bits(index)] }
    }

    /// Grows to hold another box, in registers of at most eight numbers.
    #[inline(always)]
    pub(super) fn hold<S: Simd>(&mut self, simd: S, other: &Self) {
        for register in 0..self.faces.len() / S::F32_LANES {
            let [a, b] = [&self.faces, &other.faces].map(|all| Lane::load(simd, all, register));
            // A choice of numbers would be compiled to stores under a mask, which are slow, and
            // which the next load waits for.
            b.max(a).store(&mut self.faces, register);
        }
    }

    #[inline(always)]
    pub(super) fn low(&self, d: usize) -> f32 {
        -self.faces[d]
    }

    #[inline(always)]
    pub(super) fn high(&self, d: usize) -> f32 {
        self.faces[4 + d]
    }

    /// Twice the middle, as the box of a point.
    #[inline(always)]
    pub(super) fn center(&self) -> Self {
        let mut center = [0.0; 8];
        for d in 0..4 {
            let sum = self.faces[4 + d] - self.faces[d];
            (center[d], center[4 + d]) = (-sum, sum);
        }
        Self { faces: center }
    }

    /// Half of the surface: rays meet a box in proportion to that.
    #[inline(always)]
    pub(super) fn half_area(&self) -> f32 {
        let [a, b, c, _, x, y, z, _] = self.faces;
        let (x, y, z) = (a + x, b + y, c + z);
        x * y + y * z + z * x
    }

    /// The index of what is in it.
    #[inline(always)]
    pub(super) fn index(&self) -> u32 {
        self.faces[7].to_bits()
    }
}

/// By how much boxes and what is tested in single precision must be grown where coordinates, and
/// the origins of rays, are at most `extent` from the middle: a dozen roundings of them.
pub(crate) fn rounding(extent: f64) -> f64 {
    8.0 * f64::from(f32::EPSILON) * extent
}
