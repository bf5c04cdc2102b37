//! What machines do in their own ways, and work that is compiled for each of them.

use crate::lanes::Lanes;
use crate::real::Real;
use crate::transpose::Transpose;
use pulp::{Arch, Simd, WithSimd};

/// Roots and reciprocals as the machine makes them best.
pub(crate) trait Roots<S: Simd, E: Real = f64>: Copy {
    /// `1/sqrt(x)` to 6e-13, or to rounding, and zero for zero.
    fn inverse_root(self, x: Lanes<S, E>) -> Lanes<S, E>;
    /// Twice the [`inverse_root`](Self::inverse_root), which takes fewer steps.
    fn double_inverse_root(self, x: Lanes<S, E>) -> Lanes<S, E>;
    /// `sqrt(x)` of positive numbers, to rounding.
    fn root(self, x: Lanes<S, E>) -> Lanes<S, E>;
    /// `1/x`, to rounding.
    fn reciprocal(self, x: Lanes<S, E>) -> Lanes<S, E>;
}

/// By division and square roots.
#[derive(Clone, Copy)]
pub(crate) struct Portable;

impl<S: Simd, E: Real> Roots<S, E> for Portable {
    #[inline(always)]
    fn inverse_root(self, x: Lanes<S, E>) -> Lanes<S, E> {
        let zero = x.of(0.0);
        zero.below(x, self.reciprocal(self.root(x)), zero)
    }

    #[inline(always)]
    fn double_inverse_root(self, x: Lanes<S, E>) -> Lanes<S, E> {
        let inverse = self.inverse_root(x);
        inverse + inverse
    }

    #[inline(always)]
    fn root(self, x: Lanes<S, E>) -> Lanes<S, E> {
        x.square_root()
    }

    #[inline(always)]
    fn reciprocal(self, x: Lanes<S, E>) -> Lanes<S, E> {
        x.of(1.0).over(x)
    }
}

/// By estimates of 14 bits and iterations: the inverse root by one of third order.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
pub(crate) struct Estimate;

#[cfg(target_arch = "x86_64")]
impl Roots<pulp::x86::V4> for Estimate {
    #[inline(always)]
    fn inverse_root(self, x: Lanes<pulp::x86::V4>) -> Lanes<pulp::x86::V4> {
        let simd = x.simd;
        let (one, half) = (x.of(1.0), x.of(0.5));
        let positive = simd.greater_than_f64s(x.values, simd.splat_f64s(0.0));
        let estimate = simd.avx512f._mm512_maskz_rsqrt14_pd(positive.0, pulp::cast(x.values));
        let y = Lanes { simd, values: pulp::cast(estimate) };
        let e = (x * y).times_from(y, one);
        (y * e).times_plus(e.times_plus(x.of(0.375), half), y)
    }

    #[inline(always)]
    fn double_inverse_root(self, x: Lanes<pulp::x86::V4>) -> Lanes<pulp::x86::V4> {
        let inverse = self.inverse_root(x);
        inverse + inverse
    }

    #[inline(always)]
    fn root(self, x: Lanes<pulp::x86::V4>) -> Lanes<pulp::x86::V4> {
        let y = self.inverse_root(x);
        let root = x * y;
        (y * x.of(0.5)).times_plus(root.times_from(root, x), root)
    }

    #[inline(always)]
    fn reciprocal(self, x: Lanes<pulp::x86::V4>) -> Lanes<pulp::x86::V4> {
        let simd = x.simd;
        let one = x.of(1.0);
        let estimate = simd.avx512f._mm512_rcp14_pd(pulp::cast(x.values));
        let y = Lanes { simd, values: pulp::cast(estimate) };
        let y = y.times_plus(x.times_from(y, one), y);
        y.times_plus(x.times_from(y, one), y)
    }
}

#[cfg(target_arch = "x86_64")]
impl Roots<pulp::x86::V4, f32> for Estimate {
    #[inline(always)]
    fn inverse_root(self, x: Lanes<pulp::x86::V4, f32>) -> Lanes<pulp::x86::V4, f32> {
        let simd = x.simd;
        let positive = simd.greater_than_f32s(x.values, simd.splat_f32s(0.0));
        let estimate = simd.avx512f._mm512_maskz_rsqrt14_ps(positive.0, pulp::cast(x.values));
        let y = Lanes { simd, values: pulp::cast(estimate) };
        let e = (x * y).times_from(y, x.of(1.0));
        (y * x.of(0.5)).times_plus(e, y)
    }

    #[inline(always)]
    fn double_inverse_root(self, x: Lanes<pulp::x86::V4, f32>) -> Lanes<pulp::x86::V4, f32> {
        let simd = x.simd;
        let positive = simd.greater_than_f32s(x.values, simd.splat_f32s(0.0));
        let estimate = simd.avx512f._mm512_maskz_rsqrt14_ps(positive.0, pulp::cast(x.values));
        let y = Lanes { simd, values: pulp::cast(estimate) };
        y * (x * y).times_from(y, x.of(3.0))
    }

    #[inline(always)]
    fn root(self, x: Lanes<pulp::x86::V4, f32>) -> Lanes<pulp::x86::V4, f32> {
        Portable.root(x)
    }

    #[inline(always)]
    fn reciprocal(self, x: Lanes<pulp::x86::V4, f32>) -> Lanes<pulp::x86::V4, f32> {
        Portable.reciprocal(x)
    }
}

/// All that a machine does in its own way.
pub(crate) trait Machine<S: Simd>:
    Roots<S> + Roots<S, f32> + Transpose<S, f32> + Transpose<S, f64>
{
}

impl<S, M> Machine<S> for M
where
    S: Simd,
    M: Roots<S> + Roots<S, f32> + Transpose<S, f32> + Transpose<S, f64>,
{
}

/// Work that is compiled for each kind of machine.
pub(crate) trait Kernel {
    fn run<S: Simd, M: Machine<S>>(self, simd: S, machine: M);
}

/// Runs `kernel` with the widest registers of this machine.
pub(crate) fn dispatch<K: Kernel>(kernel: K) {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V4::try_new() {
        return simd.vectorize(Widest { simd, kernel });
    }
    Arch::new().dispatch(Usual(kernel));
}

#[cfg(target_arch = "x86_64")]
struct Widest<K> {
    simd: pulp::x86::V4,
    kernel: K,
}

#[cfg(target_arch = "x86_64")]
impl<K: Kernel> pulp::NullaryFnOnce for Widest<K> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.kernel.run(self.simd, Estimate);
    }
}

pub(crate) struct Usual<K>(pub(crate) K);

impl<K: Kernel> WithSimd for Usual<K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.0.run(simd, Portable);
    }
}
