use pulp::{Arch, WithSimd};

/// Runs a kernel in the widest registers of this machine that hold at most eight numbers of single
/// precision.
pub(super) fn of_eight<K: WithSimd>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return pulp::Simd::vectorize(simd, kernel);
    }
    Arch::new().dispatch(kernel)
}
