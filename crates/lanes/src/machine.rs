//! Work that is compiled for each kind of machine.

#[cfg(target_arch = "x86_64")]
use crate::roots::Estimate;
use crate::{Portable, Roots, Transpose};
use pulp::{Arch, Simd, WithSimd};

/// All that a machine does in its own way.
pub trait Machine<S: Simd>:
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
pub trait Kernel {
    /// The work, with the registers and the ways of one machine.
    fn run<S: Simd, M: Machine<S>>(self, simd: S, machine: M);
}

/// Runs `kernel` with the widest registers of this machine.
pub fn dispatch<K: Kernel>(kernel: K) {
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
