//! Symmetric matrices of three rows and columns.

use crate::{Lane, M3, V3};
use pulp::Simd;
use std::ops::{Add, Sub};

/// A symmetric 3 x 3 matrix: xx, yy, zz, xy, xz, yz.
#[derive(Clone, Copy)]
// Registers begin at a cache line: one that crosses a line costs twice.
#[repr(align(64))]
pub struct Sym<S: Simd>(pub [Lane<S>; 6]);

impl<S: Simd> Sym<S> {
    /// Matrix `i` of an array.
    #[inline(always)]
    pub fn load(simd: S, a: &[S::f64s], i: usize) -> Self {
        let (V3([xx, yy, zz]), V3([xy, xz, yz])) =
            (V3::load(simd, a, 2 * i), V3::load(simd, a, 2 * i + 1));
        Self([xx, yy, zz, xy, xz, yz])
    }

    /// The unit matrix times `d`.
    #[inline(always)]
    pub fn diagonal(d: Lane<S>) -> Self {
        let z = d.lift(0.0);
        Self([d, d, d, z, z, z])
    }

    /// `self * v`.
    #[inline(always)]
    pub fn apply(self, v: V3<S>) -> V3<S> {
        let ([xx, yy, zz, xy, xz, yz], [x, y, z]) = (self.0, v.0);
        V3([
            xx.mul_add(x, xy.mul_add(y, xz * z)),
            xy.mul_add(x, yy.mul_add(y, yz * z)),
            xz.mul_add(x, yz.mul_add(y, zz * z)),
        ])
    }

    /// All nine entries.
    #[inline(always)]
    pub fn full(self) -> M3<S> {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        M3([V3([xx, xy, xz]), V3([xy, yy, yz]), V3([xz, yz, zz])])
    }

    /// `self * m`.
    #[inline(always)]
    pub fn times(self, m: M3<S>) -> M3<S> {
        self.full().times(m)
    }

    /// The symmetric part of `a^T b`, known to be symmetric.
    #[inline(always)]
    pub fn transposed_product(a: M3<S>, b: M3<S>) -> Self {
        Self::product_transposed(a.transposed(), b.transposed())
    }

    /// `v v^T`.
    #[inline(always)]
    pub fn outer(v: V3<S>) -> Self {
        let [x, y, z] = v.0;
        Self([x * x, y * y, z * z, x * y, x * z, y * z])
    }

    /// `(a b^T + b a^T) / 2`.
    #[inline(always)]
    pub fn symmetric_outer(a: V3<S>, b: V3<S>) -> Self {
        let ([a0, a1, a2], [b0, b1, b2]) = (a.0, b.0);
        let half = a0.lift(0.5);
        Self([
            a0 * b0,
            a1 * b1,
            a2 * b2,
            half * a0.mul_add(b1, a1 * b0),
            half * a0.mul_add(b2, a2 * b0),
            half * a1.mul_add(b2, a2 * b1),
        ])
    }

    /// `(m + m^T) / 2`.
    #[inline(always)]
    pub fn symmetric_part(m: M3<S>) -> Self {
        let half = m.0[0].0[0].lift(0.5);
        Self::twice_symmetric_part(m).scale(half)
    }

    /// `m + m^T`.
    #[inline(always)]
    pub fn twice_symmetric_part(m: M3<S>) -> Self {
        let [a, b, c] = m.0;
        let ([ax, ay, az], [bx, by, bz], [cx, cy, cz]) = (a.0, b.0, c.0);
        Self([ax + ax, by + by, cz + cz, ay + bx, az + cx, bz + cy])
    }

    /// `a b^T`, known to be symmetric.
    #[inline(always)]
    pub fn product_transposed(a: M3<S>, b: M3<S>) -> Self {
        let (a, b) = (a.0, b.0);
        Self([
            a[0].dot(b[0]),
            a[1].dot(b[1]),
            a[2].dot(b[2]),
            a[0].dot(b[1]),
            a[0].dot(b[2]),
            a[1].dot(b[2]),
        ])
    }

    /// `self * s`.
    #[inline(always)]
    pub fn scale(self, s: Lane<S>) -> Self {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        Self([xx * s, yy * s, zz * s, xy * s, xz * s, yz * s])
    }

    /// The inverse through `L D L^T`, and its signature: how many pivots are positive less how
    /// many are not.
    #[inline(always)]
    pub fn inverse(self) -> (Self, Lane<S>) {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        let i0 = xx.recip();
        let (l1, l2) = (xy * i0, xz * i0);
        let d1 = l1.negate_mul_add(xy, yy);
        let i1 = d1.recip();
        let e = l1.negate_mul_add(xz, yz);
        let l3 = e * i1;
        let d2 = l3.negate_mul_add(e, l2.negate_mul_add(xz, zz));
        let i2 = d2.recip();
        // L^-1 has the entries -l1, -l3 and l1 l3 - l2.
        let m = l1.mul_add(l3, -l2);
        let (m2, l3i) = (m * i2, -(l3 * i2));
        let (iyy, iyz) = (l3.negate_mul_add(l3i, i1), l3i);
        let ixy = m.mul_add(l3i, -(l1 * i1));
        let ixx = m.mul_add(m2, l1.mul_add(l1 * i1, i0));
        let signature = xx.sign() + d1.sign() + d2.sign();
        (Self([ixx, iyy, i2, ixy, m2, iyz]), signature)
    }
}

impl<S: Simd> Add for Sym<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        let mut out = self;
        for i in 0..6 {
            out.0[i] = self.0[i] + b.0[i];
        }
        out
    }
}

impl<S: Simd> Sub for Sym<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        let mut out = self;
        for i in 0..6 {
            out.0[i] = self.0[i] - b.0[i];
        }
        out
    }
}
