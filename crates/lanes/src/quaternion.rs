//! Rotations as quaternions.

use crate::{Lane, Mask, Select, V3};
use pulp::Simd;

/// A unit quaternion in each lane, vector part first.
#[derive(Clone, Copy)]
pub struct Quat<S: Simd> {
    /// The vector part.
    pub v: V3<S>,
    /// The scalar part.
    pub w: Lane<S>,
}

impl<S: Simd> Quat<S> {
    /// Quaternion `i` of an array.
    #[inline(always)]
    pub fn load(simd: S, a: &[S::f64s], i: usize) -> Self {
        let a = &a[4 * i..4 * i + 4];
        Self { v: V3::load(simd, a, 0), w: Lane::new(simd, a[3]) }
    }

    /// `self^-1 b`.
    #[inline(always)]
    pub fn inverse_times(self, b: Self) -> Self {
        Self {
            v: b.v.mul_add(self.w, V3::splat(b.w.simd(), 0.0) - self.v.scale(b.w))
                - self.v.cross(b.v),
            w: self.w.mul_add(b.w, self.v.dot(b.v)),
        }
    }

    /// The Cayley rotation of `u` (angle `2 atan(|u|/2)`) from the left, normalised.
    #[inline(always)]
    pub fn turned_by(self, u: V3<S>) -> Self {
        let half = u.scale(self.w.lift(0.5));
        let v = self.v + half.scale(self.w) + half.cross(self.v);
        let w = self.w - half.dot(self.v);
        let norm = w.mul_add(w, v.dot(v)).sqrt().recip();
        Self { v: v.scale(norm), w: w * norm }
    }

    /// The rotation by `angle` (rad, any number of turns) about its own d3 from the right, to
    /// rounding: `(x, y, z, w) (k sin(angle / 2) + cos(angle / 2))`.
    #[inline(always)]
    pub fn spun_by(self, angle: Lane<S>) -> Self {
        let (sin, cos) = half_turned(angle);
        let [x, y, z] = self.v.0;
        let w = self.w;
        Self {
            v: V3([
                x.mul_add(cos, y * sin),
                x.negate_mul_add(sin, y * cos),
                z.mul_add(cos, w * sin),
            ]),
            w: z.negate_mul_add(sin, w * cos),
        }
    }

    /// The directors d1, d2, d3, world components.
    #[inline(always)]
    pub fn directors(self) -> [V3<S>; 3] {
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
    pub fn log(self) -> (V3<S>, Lane<S>) {
        let sign = self.w.sign();
        let one = self.w.lift(1.0);
        let w = self.w * sign;
        let v2 = self.v.dot(self.v);
        // tan of a quarter, an eighth and a sixteenth of the angle, as multiples of |v|.
        let mut k = (one + w).recip();
        k = k * (one + k.mul_add(k * v2, one).sqrt()).recip();
        k = k * (one + k.mul_add(k * v2, one).sqrt()).recip();
        let f = k.lift(16.0) * k * atan_over(k * k * v2);
        (self.v.scale(f * sign), f * w)
    }
}

impl<S: Simd> Select<S> for Quat<S> {
    #[inline(always)]
    fn select(mask: Mask<S>, yes: Self, no: Self) -> Self {
        Self { v: mask.select(yes.v, no.v), w: mask.select(yes.w, no.w) }
    }
}

/// Sine and cosine of half an angle but for the sign of both: a quaternion and its negative are
/// one rotation. Half the angle less the nearest multiple of pi is at most pi / 2, where the Taylor
/// series are exact to rounding.
#[inline(always)]
fn half_turned<S: Simd>(angle: Lane<S>) -> (Lane<S>, Lane<S>) {
    use std::f64::consts::{FRAC_1_PI, PI};
    let half = angle * angle.lift(0.5);
    let turns = (half * angle.lift(FRAC_1_PI)).round();
    let x = turns.negate_mul_add(angle.lift(PI), half);
    let x2 = x * x;
    let (mut sin, mut cos) = (angle.lift(1.0), angle.lift(1.0));
    for k in (1..=11_i32).rev() {
        let [odd, even] = [2 * k * (2 * k + 1), 2 * k * (2 * k - 1)].map(f64::from);
        sin = (sin * x2).negate_mul_add(angle.lift(1.0 / odd), angle.lift(1.0));
        cos = (cos * x2).negate_mul_add(angle.lift(1.0 / even), angle.lift(1.0));
    }
    (sin * x, cos)
}

/// `atan(u) / u` for `u^2 <= 0.04`: its Taylor series, exact to rounding there.
#[inline(always)]
fn atan_over<S: Simd>(u2: Lane<S>) -> Lane<S> {
    let mut sum = u2.lift(-1.0 / 23.0);
    for k in (0..11_i32).rev() {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        sum = sum.mul_add(u2, u2.lift(sign / f64::from(2 * k + 1)));
    }
    sum
}
