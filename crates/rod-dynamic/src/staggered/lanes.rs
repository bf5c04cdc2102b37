//! Small vectors and matrices whose entries are SIMD lanes, one fibre in each.
//!
//! One source serves one fibre and eight. Every function is `inline(always)`, because only then does it
//! take on the caller's target features.

use aligned_vec::{AVec, ConstAlign, avec};
use pulp::Simd;
use pulp::bytemuck::Zeroable;
pub(super) use rapunzel_lanes::Lane;
use std::ops::{Add, AddAssign, Sub, SubAssign};

/// An array of registers that begins at a cache line: a register that crosses one costs twice.
pub(super) type Array<S> = AVec<<S as Simd>::f64s, ConstAlign<64>>;

/// An array of `count` zeros.
pub(super) fn zeros<S: Simd>(count: usize) -> Array<S> {
    avec![[64]| S::f64s::zeroed(); count]
}

/// A vector in each lane.
#[derive(Clone, Copy)]
pub(super) struct V3<S: Simd>(pub(super) [Lane<S>; 3]);

impl<S: Simd> V3<S> {
    /// Vector `i` of an array.
    #[inline(always)]
    pub(super) fn load(simd: S, a: &[S::f64s], i: usize) -> Self {
        let a = &a[3 * i..3 * i + 3];
        Self([Lane::new(simd, a[0]), Lane::new(simd, a[1]), Lane::new(simd, a[2])])
    }
    #[inline(always)]
    pub(super) fn splat(simd: S, x: f64) -> Self {
        Self([Lane::splat(simd, x); 3])
    }
    #[inline(always)]
    pub(super) fn dot(self, b: Self) -> Lane<S> {
        let [x, y, z] = self.0;
        x.fma(b.0[0], y.fma(b.0[1], z * b.0[2]))
    }
    #[inline(always)]
    pub(super) fn cross(self, b: Self) -> Self {
        let ([a0, a1, a2], [b0, b1, b2]) = (self.0, b.0);
        Self([a2.nma(b1, a1 * b2), a0.nma(b2, a2 * b0), a1.nma(b0, a0 * b1)])
    }
    #[inline(always)]
    pub(super) fn scale(self, s: Lane<S>) -> Self {
        let [x, y, z] = self.0;
        Self([x * s, y * s, z * s])
    }
    /// `self * s + c`.
    #[inline(always)]
    pub(super) fn fma(self, s: Lane<S>, c: Self) -> Self {
        let [x, y, z] = self.0;
        Self([x.fma(s, c.0[0]), y.fma(s, c.0[1]), z.fma(s, c.0[2])])
    }
    /// Product by components.
    #[inline(always)]
    pub(super) fn times(self, b: Self) -> Self {
        let [x, y, z] = self.0;
        Self([x * b.0[0], y * b.0[1], z * b.0[2]])
    }
    /// `self` where `flag > 0`, else `no`.
    #[inline(always)]
    pub(super) fn positive_or(self, flag: Lane<S>, no: Self) -> Self {
        let ([x, y, z], [a, b, c]) = (self.0, no.0);
        Self([flag.positive_or(x, a), flag.positive_or(y, b), flag.positive_or(z, c)])
    }
    #[inline(always)]
    pub(super) fn max_abs(self) -> Lane<S> {
        let [x, y, z] = self.0;
        x.abs().max(y.abs()).max(z.abs())
    }
}

impl<S: Simd> Add for V3<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        let [x, y, z] = self.0;
        Self([x + b.0[0], y + b.0[1], z + b.0[2]])
    }
}

impl<S: Simd> AddAssign for V3<S> {
    #[inline(always)]
    fn add_assign(&mut self, b: Self) {
        *self = *self + b;
    }
}

impl<S: Simd> Sub for V3<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        let [x, y, z] = self.0;
        Self([x - b.0[0], y - b.0[1], z - b.0[2]])
    }
}

impl<S: Simd> SubAssign for V3<S> {
    #[inline(always)]
    fn sub_assign(&mut self, b: Self) {
        *self = *self - b;
    }
}

/// A 3 x 3 matrix in each lane, by rows.
#[derive(Clone, Copy)]
pub(super) struct M3<S: Simd>(pub(super) [V3<S>; 3]);

impl<S: Simd> M3<S> {
    #[inline(always)]
    pub(super) fn splat(simd: S, x: f64) -> Self {
        Self([V3::splat(simd, x); 3])
    }
    #[inline(always)]
    pub(super) fn apply(self, v: V3<S>) -> V3<S> {
        let [a, b, c] = self.0;
        V3([a.dot(v), b.dot(v), c.dot(v)])
    }
    /// `self^T v`.
    #[inline(always)]
    pub(super) fn apply_transposed(self, v: V3<S>) -> V3<S> {
        let [a, b, c] = self.0;
        a.fma(v.0[0], b.fma(v.0[1], c.scale(v.0[2])))
    }
    #[inline(always)]
    pub(super) fn transposed(self) -> Self {
        let [a, b, c] = self.0;
        let row = |i: usize| V3([a.0[i], b.0[i], c.0[i]]);
        Self([row(0), row(1), row(2)])
    }
    #[inline(always)]
    pub(super) fn times(self, b: Self) -> Self {
        let [x, y, z] = self.0;
        Self([b.apply_transposed(x), b.apply_transposed(y), b.apply_transposed(z)])
    }
    #[inline(always)]
    pub(super) fn scale(self, s: Lane<S>) -> Self {
        let [a, b, c] = self.0;
        Self([a.scale(s), b.scale(s), c.scale(s)])
    }
}

impl<S: Simd> M3<S> {
    /// `self^-1 v` by Cramer's rule.
    #[inline(always)]
    pub(super) fn solve(self, v: V3<S>) -> V3<S> {
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

/// A symmetric 3 x 3 matrix: xx, yy, zz, xy, xz, yz.
#[derive(Clone, Copy)]
pub(super) struct Sym<S: Simd>(pub(super) [Lane<S>; 6]);

impl<S: Simd> Sym<S> {
    /// Matrix `i` of an array.
    #[inline(always)]
    pub(super) fn load(simd: S, a: &[S::f64s], i: usize) -> Self {
        let (V3([xx, yy, zz]), V3([xy, xz, yz])) =
            (V3::load(simd, a, 2 * i), V3::load(simd, a, 2 * i + 1));
        Self([xx, yy, zz, xy, xz, yz])
    }
    #[inline(always)]
    pub(super) fn diagonal(d: Lane<S>) -> Self {
        let z = d.lift(0.0);
        Self([d, d, d, z, z, z])
    }
    #[inline(always)]
    pub(super) fn apply(self, v: V3<S>) -> V3<S> {
        let ([xx, yy, zz, xy, xz, yz], [x, y, z]) = (self.0, v.0);
        V3([
            xx.fma(x, xy.fma(y, xz * z)),
            xy.fma(x, yy.fma(y, yz * z)),
            xz.fma(x, yz.fma(y, zz * z)),
        ])
    }
    #[inline(always)]
    pub(super) fn full(self) -> M3<S> {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        M3([V3([xx, xy, xz]), V3([xy, yy, yz]), V3([xz, yz, zz])])
    }
    /// `self * m`.
    #[inline(always)]
    pub(super) fn times(self, m: M3<S>) -> M3<S> {
        self.full().times(m)
    }
    /// The symmetric part of `a^T b`, known to be symmetric.
    #[inline(always)]
    pub(super) fn transposed_product(a: M3<S>, b: M3<S>) -> Self {
        Self::product_transposed(a.transposed(), b.transposed())
    }
    /// `v v^T`.
    #[inline(always)]
    pub(super) fn outer(v: V3<S>) -> Self {
        let [x, y, z] = v.0;
        Self([x * x, y * y, z * z, x * y, x * z, y * z])
    }
    /// `(a b^T + b a^T) / 2`.
    #[inline(always)]
    pub(super) fn symmetric_outer(a: V3<S>, b: V3<S>) -> Self {
        let ([a0, a1, a2], [b0, b1, b2]) = (a.0, b.0);
        let half = a0.lift(0.5);
        Self([
            a0 * b0,
            a1 * b1,
            a2 * b2,
            half * a0.fma(b1, a1 * b0),
            half * a0.fma(b2, a2 * b0),
            half * a1.fma(b2, a2 * b1),
        ])
    }
    /// `(m + m^T) / 2`.
    #[inline(always)]
    pub(super) fn symmetric_part(m: M3<S>) -> Self {
        let half = m.0[0].0[0].lift(0.5);
        Self::twice_symmetric_part(m).scale(half)
    }
    /// `m + m^T`.
    #[inline(always)]
    pub(super) fn twice_symmetric_part(m: M3<S>) -> Self {
        let [a, b, c] = m.0;
        let ([ax, ay, az], [bx, by, bz], [cx, cy, cz]) = (a.0, b.0, c.0);
        Self([ax + ax, by + by, cz + cz, ay + bx, az + cx, bz + cy])
    }
    /// `a b^T`, known to be symmetric.
    #[inline(always)]
    pub(super) fn product_transposed(a: M3<S>, b: M3<S>) -> Self {
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
    #[inline(always)]
    pub(super) fn scale(self, s: Lane<S>) -> Self {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        Self([xx * s, yy * s, zz * s, xy * s, xz * s, yz * s])
    }
    /// The inverse through `L D L^T`, and its signature: how many pivots are positive less how
    /// many are not.
    #[inline(always)]
    pub(super) fn inverse(self) -> (Self, Lane<S>) {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        let i0 = xx.recip();
        let (l1, l2) = (xy * i0, xz * i0);
        let d1 = l1.nma(xy, yy);
        let i1 = d1.recip();
        let e = l1.nma(xz, yz);
        let l3 = e * i1;
        let d2 = l3.nma(e, l2.nma(xz, zz));
        let i2 = d2.recip();
        // L^-1 has the entries -l1, -l3 and l1 l3 - l2.
        let m = l1.fma(l3, -l2);
        let (m2, l3i) = (m * i2, -(l3 * i2));
        let (iyy, iyz) = (l3.nma(l3i, i1), l3i);
        let ixy = m.fma(l3i, -(l1 * i1));
        let ixx = m.fma(m2, l1.fma(l1 * i1, i0));
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

/// A unit quaternion in each lane, vector part first.
#[derive(Clone, Copy)]
pub(super) struct Quat<S: Simd> {
    pub(super) v: V3<S>,
    pub(super) w: Lane<S>,
}

impl<S: Simd> Quat<S> {
    /// Quaternion `i` of an array.
    #[inline(always)]
    pub(super) fn load(simd: S, a: &[S::f64s], i: usize) -> Self {
        let a = &a[4 * i..4 * i + 4];
        Self { v: V3::load(simd, a, 0), w: Lane::new(simd, a[3]) }
    }
    /// `self^-1 b`.
    #[inline(always)]
    pub(super) fn inverse_times(self, b: Self) -> Self {
        Self {
            v: b.v.fma(self.w, V3::splat(b.w.simd(), 0.0) - self.v.scale(b.w)) - self.v.cross(b.v),
            w: self.w.fma(b.w, self.v.dot(b.v)),
        }
    }
    /// The Cayley rotation of `u` (angle `2 atan(|u|/2)`) from the left, normalised.
    #[inline(always)]
    pub(super) fn turned_by(self, u: V3<S>) -> Self {
        let half = u.scale(self.w.lift(0.5));
        let v = self.v + half.scale(self.w) + half.cross(self.v);
        let w = self.w - half.dot(self.v);
        let norm = w.fma(w, v.dot(v)).sqrt().recip();
        Self { v: v.scale(norm), w: w * norm }
    }
    /// `self` where `flag > 0`, else `no`.
    #[inline(always)]
    pub(super) fn positive_or(self, flag: Lane<S>, no: Self) -> Self {
        Self { v: self.v.positive_or(flag, no.v), w: flag.positive_or(self.w, no.w) }
    }
    /// The directors d1, d2, d3, world components.
    #[inline(always)]
    pub(super) fn directors(self) -> [V3<S>; 3] {
        let ([x, y, z], w) = (self.v.0, self.w);
        let one = w.lift(1.0);
        let (x2, y2, z2) = (x + x, y + y, z + z);
        let (xx, yy, zz) = (x * x2, y * y2, z * z2);
        let (xy, xz, yz) = (x * y2, x * z2, y * z2);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        [
            V3([one - (yy + zz), xy + wz, xz - wy]),
            V3([xy - wz, one - (xx + zz), yz + wx]),
            V3([xz + wy, yz - wx, one - (xx + yy)]),
        ]
    }
    /// The rotation vector (length at most pi), and `w |phi| / |v|` with both signs made positive.
    #[inline(always)]
    pub(super) fn log(self) -> (V3<S>, Lane<S>) {
        let sign = self.w.sign();
        let one = self.w.lift(1.0);
        let w = self.w * sign;
        let v2 = self.v.dot(self.v);
        // tan of a quarter, an eighth and a sixteenth of the angle, as multiples of |v|.
        let mut k = (one + w).recip();
        k = k * (one + k.fma(k * v2, one).sqrt()).recip();
        k = k * (one + k.fma(k * v2, one).sqrt()).recip();
        let f = k.lift(16.0) * k * atan_over(k * k * v2);
        (self.v.scale(f * sign), f * w)
    }
}

/// `atan(u) / u` for `u^2 <= 0.04`: its Taylor series, exact to rounding there.
#[inline(always)]
fn atan_over<S: Simd>(u2: Lane<S>) -> Lane<S> {
    let mut sum = u2.lift(-1.0 / 23.0);
    for k in (0..11_i32).rev() {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        sum = sum.fma(u2, u2.lift(sign / f64::from(2 * k + 1)));
    }
    sum
}
