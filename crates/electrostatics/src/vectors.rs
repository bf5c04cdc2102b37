//! Vectors in each lane, and the logarithm that straight lines have in common.

use pulp::Simd;
use rapunzel_lanes::{Lane, Real, Roots, ln};

/// Vector in each lane. Not a [`rapunzel_lanes::V3`], which rounds scalar products in another
/// order: forces would change in their last digits.
pub(crate) type LaneVector<S, E = f64> = [Lane<S, E>; 3];

/// Scalar product.
#[inline(always)]
pub(crate) fn dot<S: Simd, E: Real>(a: &LaneVector<S, E>, b: &LaneVector<S, E>) -> Lane<S, E> {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

/// Vector product.
#[inline(always)]
pub(crate) fn cross<S: Simd, E: Real>(
    a: &LaneVector<S, E>,
    b: &LaneVector<S, E>,
) -> LaneVector<S, E> {
    [
        a[2].negate_mul_add(b[1], a[1] * b[2]),
        a[0].negate_mul_add(b[2], a[2] * b[0]),
        a[1].negate_mul_add(b[0], a[0] * b[1]),
    ]
}

/// Difference `a - b`.
#[inline(always)]
pub(crate) fn minus<S: Simd, E: Real>(
    a: &LaneVector<S, E>,
    b: &LaneVector<S, E>,
) -> LaneVector<S, E> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Product `a factor`.
#[inline(always)]
pub(crate) fn scaled<S: Simd, E: Real>(
    a: &LaneVector<S, E>,
    factor: Lane<S, E>,
) -> LaneVector<S, E> {
    [a[0] * factor, a[1] * factor, a[2] * factor]
}

/// Sum `a + b factor`.
#[inline(always)]
pub(crate) fn along<S: Simd, E: Real>(
    a: &LaneVector<S, E>,
    b: &LaneVector<S, E>,
    factor: Lane<S, E>,
) -> LaneVector<S, E> {
    [b[0].mul_add(factor, a[0]), b[1].mul_add(factor, a[1]), b[2].mul_add(factor, a[2])]
}

/// Logarithm `ln((R1 + w1)/(R0 + w0))` in the form that does not cancel, where `R^2 - w^2` is the
/// same for both.
#[inline(always)]
pub(crate) fn log<S: Simd, R: Roots<S>>(roots: R, w: [Lane<S>; 2], r: [Lane<S>; 2]) -> Lane<S> {
    let sign = (w[0] + w[1]).less_than(w[0].lift(0.0)).select(w[0].lift(-1.0), w[0].lift(1.0));
    let (a, b) = (sign.mul_add(w[0], r[0]), sign.mul_add(w[1], r[1]));
    sign * ln(roots, b * roots.recip(a))
}
