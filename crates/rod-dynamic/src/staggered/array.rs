//! Arrays of registers.

use aligned_vec::{AVec, ConstAlign, avec};
use pulp::Simd;
use pulp::bytemuck::{self, Pod, Zeroable};
use rapunzel_lanes::{Lane, Quat, V3};

/// An array of registers that begins at a cache line: a register that crosses one costs twice.
pub(super) type Array<S> = AVec<<S as Simd>::f64s, ConstAlign<64>>;

/// An array of `count` zeros.
pub(super) fn zeros<S: Simd>(count: usize) -> Array<S> {
    avec![[64]| S::f64s::zeroed(); count]
}

/// Gives an array `count` registers.
pub(super) fn fit<S: Simd>(array: &mut Array<S>, count: usize) {
    if array.capacity() < count {
        *array = zeros::<S>(count);
    }
    array.resize(count, S::f64s::zeroed());
}

/// Writes number `i` of one lane.
pub(super) fn set<T: Pod>(a: &mut [T], i: usize, lane: usize, x: f64) {
    let lanes = size_of::<T>() / size_of::<f64>();
    bytemuck::cast_slice_mut::<T, f64>(a)[i * lanes + lane] = x;
}

/// Reads number `i` of one lane.
pub(super) fn at<T: Pod>(a: &[T], i: usize, lane: usize) -> f64 {
    let lanes = size_of::<T>() / size_of::<f64>();
    bytemuck::cast_slice::<T, f64>(a)[i * lanes + lane]
}

/// The numbers of each vector of all lanes, component by component.
pub(super) fn lanes<T: Pod>(a: &mut [T]) -> impl Iterator<Item = &mut [f64]> {
    let lanes = size_of::<T>() / size_of::<f64>();
    bytemuck::cast_slice_mut::<T, f64>(a).chunks_exact_mut(3 * lanes)
}

/// Writes vector number `i`.
#[inline(always)]
pub(super) fn store<S: Simd>(a: &mut [S::f64s], i: usize, v: V3<S>) {
    let a = &mut a[3 * i..3 * i + 3];
    for k in 0..3 {
        a[k] = v.0[k].value;
    }
}

/// Writes quaternion number `i`.
#[inline(always)]
pub(super) fn store_quat<S: Simd>(a: &mut [S::f64s], i: usize, q: Quat<S>) {
    let a = &mut a[4 * i..4 * i + 4];
    for k in 0..3 {
        a[k] = q.v.0[k].value;
    }
    a[3] = q.w.value;
}

/// The number in one lane.
#[inline(always)]
pub(super) fn get<S: Simd>(x: Lane<S>, lane: usize) -> f64 {
    bytemuck::cast_slice::<S::f64s, f64>(std::slice::from_ref(&x.value))[lane]
}
