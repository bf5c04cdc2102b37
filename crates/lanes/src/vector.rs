//! Vectors of three components.

use crate::{Lane, Mask, Real, Select};
use pulp::Simd;
use std::ops::{Add, AddAssign, Sub, SubAssign};

/// A vector in each lane.
#[derive(Clone, Copy)]
// Registers begin at a cache line: one that crosses a line costs twice.
#[repr(align(64))]
pub struct V3<S: Simd, E: Real = f64>(pub [Lane<S, E>; 3]);

impl<S: Simd> V3<S> {
    /// Vector `i` of an array.
    #[inline(always)]
    pub fn load(simd: S, a: &[S::f64s], i: usize) -> Self {
        let a = &a[3 * i..3 * i + 3];
        Self([Lane::new(simd, a[0]), Lane::new(simd, a[1]), Lane::new(simd, a[2])])
    }
}

impl<S: Simd, E: Real> V3<S, E> {
    /// `x` in all components of all lanes.
    #[inline(always)]
    pub fn splat(simd: S, x: E) -> Self {
        Self([Lane::splat(simd, x); 3])
    }

    /// The scalar product.
    #[inline(always)]
    pub fn dot(self, b: Self) -> Lane<S, E> {
        let [x, y, z] = self.0;
        x.mul_add(b.0[0], y.mul_add(b.0[1], z * b.0[2]))
    }

    /// The vector product.
    #[inline(always)]
    pub fn cross(self, b: Self) -> Self {
        let ([a0, a1, a2], [b0, b1, b2]) = (self.0, b.0);
        Self([
            a2.negate_mul_add(b1, a1 * b2),
            a0.negate_mul_add(b2, a2 * b0),
            a1.negate_mul_add(b0, a0 * b1),
        ])
    }

    /// `self * s`.
    #[inline(always)]
    pub fn scale(self, s: Lane<S, E>) -> Self {
        let [x, y, z] = self.0;
        Self([x * s, y * s, z * s])
    }

    /// `self * s + c`.
    #[inline(always)]
    pub fn mul_add(self, s: Lane<S, E>, c: Self) -> Self {
        let [x, y, z] = self.0;
        Self([x.mul_add(s, c.0[0]), y.mul_add(s, c.0[1]), z.mul_add(s, c.0[2])])
    }

    /// Product by components.
    #[inline(always)]
    pub fn times(self, b: Self) -> Self {
        let [x, y, z] = self.0;
        Self([x * b.0[0], y * b.0[1], z * b.0[2]])
    }

    /// The largest of the absolute values of the components.
    #[inline(always)]
    pub fn max_abs(self) -> Lane<S, E> {
        let [x, y, z] = self.0;
        x.abs().max(y.abs()).max(z.abs())
    }
}

impl<S: Simd, E: Real> Add for V3<S, E> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        let [x, y, z] = self.0;
        Self([x + b.0[0], y + b.0[1], z + b.0[2]])
    }
}

impl<S: Simd, E: Real> AddAssign for V3<S, E> {
    #[inline(always)]
    fn add_assign(&mut self, b: Self) {
        *self = *self + b;
    }
}

impl<S: Simd, E: Real> Sub for V3<S, E> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        let [x, y, z] = self.0;
        Self([x - b.0[0], y - b.0[1], z - b.0[2]])
    }
}

impl<S: Simd, E: Real> SubAssign for V3<S, E> {
    #[inline(always)]
    fn sub_assign(&mut self, b: Self) {
        *self = *self - b;
    }
}

impl<S: Simd, E: Real> Select<S, E> for V3<S, E> {
    #[inline(always)]
    fn select(mask: Mask<S, E>, yes: Self, no: Self) -> Self {
        let ([x, y, z], [a, b, c]) = (yes.0, no.0);
        Self([mask.select(x, a), mask.select(y, b), mask.select(z, c)])
    }
}
