//! Arrays of registers.

use aligned_vec::{AVec, ConstAlign, avec};
use pulp::Simd;
use pulp::bytemuck::Zeroable;

/// An array of registers that begins at a cache line: a register that crosses one costs twice.
pub(super) type Array<S> = AVec<<S as Simd>::f64s, ConstAlign<64>>;

/// An array of `count` zeros.
pub(super) fn zeros<S: Simd>(count: usize) -> Array<S> {
    avec![[64]| S::f64s::zeroed(); count]
}
