/// A box in single precision, m, from the middle of a tree.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(32))]
pub(crate) struct RayBox {
    /// The lowest coordinates, negated, and the highest, so that a box grows by maxima alone. What
    /// lies behind either fills the register; a builder keeps an index in the last.
    faces: [f32; 8],
}

impl RayBox {
    /// The box that holds nothing.
    pub(crate) const EMPTY: Self = Self { faces: [f32::NEG_INFINITY; 8] };

    /// The box of two corners.
    pub(crate) fn new(low: [f32; 3], high: [f32; 3]) -> Self {
        let ([a, b, c], [x, y, z]) = (low, high);
        Self { faces: [-a, -b, -c, 0.0, x, y, z, 0.0] }
    }

    /// Grows to hold another box.
    #[inline(always)]
    pub(super) fn hold(&mut self, other: &Self) {
        // Whole at once: single numbers would be stored under a mask, which the next load waits
        // for.
        let mut faces = [0.0; 8];
        for d in 0..8 {
            let (a, b) = (self.faces[d], other.faces[d]);
            faces[d] = if b > a { b } else { a };
        }
        self.faces = faces;
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

    /// The index that the builder gave it.
    #[inline(always)]
    pub(super) fn index(&self) -> u32 {
        self.faces[7].to_bits()
    }

    pub(super) fn set_index(&mut self, index: u32) {
        self.faces[7] = f32::from_bits(index);
    }
}

/// By how much boxes and what is tested in single precision must be grown where coordinates, and
/// the origins of rays, are at most `extent` from the middle: a dozen roundings of them.
pub(crate) fn rounding(extent: f64) -> f64 {
    8.0 * f64::from(f32::EPSILON) * extent
}
