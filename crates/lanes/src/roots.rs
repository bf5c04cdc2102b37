//! Roots and reciprocals, of which machines have their own ways.

use crate::{Lane, Real};
use pulp::Simd;

/// Roots and reciprocals as the machine makes them best.
pub trait Roots<S: Simd, E: Real = f64>: Copy {
    /// `1/sqrt(x)` to 6e-13, or to rounding, and zero for zero.
    fn rsqrt(self, x: Lane<S, E>) -> Lane<S, E>;
    /// Twice the [`rsqrt`](Self::rsqrt), which takes fewer steps.
    fn double_rsqrt(self, x: Lane<S, E>) -> Lane<S, E>;
    /// `sqrt(x)` of positive numbers, to rounding.
    fn sqrt(self, x: Lane<S, E>) -> Lane<S, E>;
    /// `1/x`, to rounding.
    fn recip(self, x: Lane<S, E>) -> Lane<S, E>;
}

/// Roots and reciprocals by division and square roots.
#[derive(Clone, Copy)]
pub struct Portable;

impl<S: Simd, E: Real> Roots<S, E> for Portable {
    #[inline(always)]
    fn rsqrt(self, x: Lane<S, E>) -> Lane<S, E> {
        let zero = x.lift(0.0);
        x.positive().select(self.recip(self.sqrt(x)), zero)
    }

    #[inline(always)]
    fn double_rsqrt(self, x: Lane<S, E>) -> Lane<S, E> {
        let inverse = self.rsqrt(x);
        inverse + inverse
    }

    #[inline(always)]
    fn sqrt(self, x: Lane<S, E>) -> Lane<S, E> {
        x.sqrt()
    }

    #[inline(always)]
    fn recip(self, x: Lane<S, E>) -> Lane<S, E> {
        x.recip()
    }
}

/// Roots and reciprocals by estimates of 14 bits and iterations: the inverse root by one of third
/// order.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
pub(crate) struct Estimate;

#[cfg(target_arch = "x86_64")]
impl Roots<pulp::x86::V4> for Estimate {
    #[inline(always)]
    fn rsqrt(self, x: Lane<pulp::x86::V4>) -> Lane<pulp::x86::V4> {
        let simd = x.simd();
        let (one, half) = (x.lift(1.0), x.lift(0.5));
        let positive = simd.greater_than_f64s(x.value, simd.splat_f64s(0.0));
        let estimate = simd.avx512f._mm512_maskz_rsqrt14_pd(positive.0, pulp::cast(x.value));
        let y = Lane::new(simd, pulp::cast(estimate));
        let e = (x * y).negate_mul_add(y, one);
        (y * e).mul_add(e.mul_add(x.lift(0.375), half), y)
    }

    #[inline(always)]
    fn double_rsqrt(self, x: Lane<pulp::x86::V4>) -> Lane<pulp::x86::V4> {
        let inverse = self.rsqrt(x);
        inverse + inverse
    }

    #[inline(always)]
    fn sqrt(self, x: Lane<pulp::x86::V4>) -> Lane<pulp::x86::V4> {
        let y = self.rsqrt(x);
        let root = x * y;
        (y * x.lift(0.5)).mul_add(root.negate_mul_add(root, x), root)
    }

    #[inline(always)]
    fn recip(self, x: Lane<pulp::x86::V4>) -> Lane<pulp::x86::V4> {
        let simd = x.simd();
        let one = x.lift(1.0);
        let estimate = simd.avx512f._mm512_rcp14_pd(pulp::cast(x.value));
        let y = Lane::new(simd, pulp::cast(estimate));
        let y = y.mul_add(x.negate_mul_add(y, one), y);
        y.mul_add(x.negate_mul_add(y, one), y)
    }
}

#[cfg(target_arch = "x86_64")]
impl Roots<pulp::x86::V4, f32> for Estimate {
    #[inline(always)]
    fn rsqrt(self, x: Lane<pulp::x86::V4, f32>) -> Lane<pulp::x86::V4, f32> {
        let simd = x.simd();
        let positive = simd.greater_than_f32s(x.value, simd.splat_f32s(0.0));
        let estimate = simd.avx512f._mm512_maskz_rsqrt14_ps(positive.0, pulp::cast(x.value));
        let y = Lane::new(simd, pulp::cast(estimate));
        let e = (x * y).negate_mul_add(y, x.lift(1.0));
        (y * x.lift(0.5)).mul_add(e, y)
    }

    #[inline(always)]
    fn double_rsqrt(self, x: Lane<pulp::x86::V4, f32>) -> Lane<pulp::x86::V4, f32> {
        let simd = x.simd();
        let positive = simd.greater_than_f32s(x.value, simd.splat_f32s(0.0));
        let estimate = simd.avx512f._mm512_maskz_rsqrt14_ps(positive.0, pulp::cast(x.value));
        let y = Lane::new(simd, pulp::cast(estimate));
        y * (x * y).negate_mul_add(y, x.lift(3.0))
    }

    #[inline(always)]
    fn sqrt(self, x: Lane<pulp::x86::V4, f32>) -> Lane<pulp::x86::V4, f32> {
        Portable.sqrt(x)
    }

    #[inline(always)]
    fn recip(self, x: Lane<pulp::x86::V4, f32>) -> Lane<pulp::x86::V4, f32> {
        Portable.recip(x)
    }
}
