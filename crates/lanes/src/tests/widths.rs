//! Work done with registers of every width.

use crate::machine::Usual;
use crate::{Kernel, dispatch};
use pulp::{Arch, NullaryFnOnce, Scalar, Scalar128b, Scalar512b, Simd, WithSimd};

/// Work by registers of one width, with the instructions that they need.
struct At<S, W>(S, W);

impl<S: Simd, W: WithSimd> NullaryFnOnce for At<S, W> {
    type Output = W::Output;

    #[inline(always)]
    fn call(self) -> W::Output {
        self.1.with_simd(self.0)
    }
}

/// Results of work by registers of every width that this machine can have.
pub(super) fn by_all_widths<W: WithSimd>(work: impl Fn() -> W) -> Vec<W::Output> {
    fn at<S: Simd, W: WithSimd>(simd: S, work: W) -> W::Output {
        simd.vectorize(At(simd, work))
    }
    let mut found = vec![
        Arch::new().dispatch(work()),
        at(Scalar::new(), work()),
        at(Scalar128b, work()),
        at(Scalar512b, work()),
    ];
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        found.push(at(simd, work()));
        found.push(at(pulp::x86::V3_128b(simd), work()));
        found.push(at(pulp::x86::V3_512b(simd), work()));
    }
    found
}

/// Work on the machine's own registers, and on those of every width without its own ways.
pub(super) fn by_all_machines<K: Kernel + Copy>(kernel: K) {
    dispatch(kernel);
    by_all_widths(|| Usual(kernel));
}
