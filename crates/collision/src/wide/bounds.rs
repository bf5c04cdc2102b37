//! Boxes in single precision.

/// What lies between planes, two in each of some directions: along the axes a box (world), m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds<const D: usize = 3> {
    pub(super) low: [f32; D],
    pub(super) high: [f32; D],
}

impl<const D: usize> Bounds<D> {
    /// The box that holds nothing.
    pub(super) const EMPTY: Self = Self { low: [f32::INFINITY; D], high: [f32::NEG_INFINITY; D] };

    /// Grows to hold `other`.
    #[inline(always)]
    pub(super) fn hold(&mut self, other: &Self) {
        for d in 0..D {
            self.low[d] = self.low[d].min(other.low[d]);
            self.high[d] = self.high[d].max(other.high[d]);
        }
    }
}

impl Bounds {
    /// Surface, m².
    pub(super) fn area(&self) -> f32 {
        let [x, y, z]: [f32; 3] = std::array::from_fn(|d| self.high[d] - self.low[d]);
        2.0 * (x * y + y * z + z * x)
    }
}

/// The single next to `x`.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "rounding is what it is for")]
pub(super) fn nearest(x: f64) -> f32 {
    x as f32
}

/// A single that is not above `x`, a number: the largest, but for a last place next to zero and to
/// the largest singles.
#[inline(always)]
pub(super) fn below(x: f64) -> f32 {
    let nearest = nearest(x);
    // More than half a unit in the last place is taken off and less than a whole one: the result
    // rounds to the next single down. A sum, not a step of the bits, so that it is vector code.
    let finite = if nearest < f32::MAX { nearest } else { f32::MAX };
    let next = finite - (finite.abs() * 6e-8 + 1e-45);
    if f64::from(nearest) > x { next } else { nearest }
}

/// A single that is not below `x`, a number: the least, but for the same.
#[inline(always)]
pub(super) fn above(x: f64) -> f32 {
    -below(-x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn outward(x: f64) -> bool {
        f64::from(below(x)) <= x && x <= f64::from(above(x))
    }

    fn tight(x: f64) -> bool {
        let (low, high) = (below(x), above(x));
        low == high || low.next_up() == high
    }

    proptest! {
        #[test]
        fn rounding_is_outward(x in prop::num::f64::ANY.prop_filter("a number", |x| x.is_finite())) {
            prop_assert!(outward(x));
            prop_assert!(tight(x) || !(1e-37..1e38).contains(&x.abs()));
        }

        #[test]
        fn rounding_of_lengths_is_tight(x in -1e3..1e3_f64) {
            prop_assert!(outward(x) && tight(x));
        }
    }

    #[test]
    fn rounding_is_outward_at_the_ends_of_the_range() {
        for x in [0.0, 1e-46, 1e-45, 1e-40, 1.17e-38, 1.18e-38, 3.4e38, 3.5e38, f64::MAX] {
            assert!(outward(x) && outward(-x), "{x}");
        }
    }
}
