//! Matrices of three rows and columns.

use crate::{Lane, V3};
use pulp::Simd;
use std::ops::{Add, Sub};

/// A 3 x 3 matrix in each lane, by rows.
#[derive(Clone, Copy)]
pub struct M3<S: Simd>(pub [V3<S>; 3]);

impl<S: Simd> M3<S> {
    /// `x` in all entries of all lanes.
    #[inline(always)]
    pub fn splat(simd: S, x: f64) -> Self {
        Self([V3::splat(simd, x); 3])
    }

    /// `self * v`.
    #[inline(always)]
    pub fn apply(self, v: V3<S>) -> V3<S> {
        let [a, b, c] = self.0;
        V3([a.dot(v), b.dot(v), c.dot(v)])
    }

    /// `self^T v`.
    #[inline(always)]
    pub fn apply_transposed(self, v: V3<S>) -> V3<S> {
        let [a, b, c] = self.0;
        a.mul_add(v.0[0], b.mul_add(v.0[1], c.scale(v.0[2])))
    }

    /// The transpose.
    #[inline(always)]
    pub fn transposed(self) -> Self {
        let [a, b, c] = self.0;
        let row = |i: usize| V3([a.0[i], b.0[i], c.0[i]]);
        Self([row(0), row(1), row(2)])
    }

    /// `self * b`.
    #[inline(always)]
    pub fn times(self, b: Self) -> Self {
        let [x, y, z] = self.0;
        Self([b.apply_transposed(x), b.apply_transposed(y), b.apply_transposed(z)])
    }

    /// `self * s`.
    #[inline(always)]
    pub fn scale(self, s: Lane<S>) -> Self {
        let [a, b, c] = self.0;
        Self([a.scale(s), b.scale(s), c.scale(s)])
    }

    /// `self^-1 v` by Cramer's rule.
    #[inline(always)]
    pub fn solve(self, v: V3<S>) -> V3<S> {
        let [a, b, c] = self.transposed().0;
        let (bc, ca, ab) = (b.cross(c), c.cross(a), a.cross(b));
        V3([bc.dot(v), ca.dot(v), ab.dot(v)]).scale(a.dot(bc).recip())
    }
}

impl<S: Simd> Add for M3<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self([self.0[0] + b.0[0], self.0[1] + b.0[1], self.0[2] + b.0[2]])
    }
}

impl<S: Simd> Sub for M3<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self([self.0[0] - b.0[0], self.0[1] - b.0[1], self.0[2] - b.0[2]])
    }
}
