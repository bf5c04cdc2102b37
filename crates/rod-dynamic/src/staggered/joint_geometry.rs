//! Rotations at a joint: derivatives of the logarithm, and of directors.

use super::array::store;
use pulp::Simd;
use rapunzel_lanes::{Lane, M3, Quat, Sym, V3};

/// Stores the directors of the rotations `q` as those at the start of the step, in the lanes where
/// `wanted > 0`.
#[inline(always)]
pub(super) fn keep_directors<S: Simd>(d_start: &mut [S::f64s], q: &[S::f64s], wanted: Lane<S>) {
    let simd = wanted.simd();
    for e in 0..q.len() / 4 {
        let d = Quat::load(simd, q, e).directors();
        for k in 0..3 {
            let old = V3::load(simd, d_start, 3 * e + k);
            store(d_start, 3 * e + k, wanted.positive().select(d[k], old));
        }
    }
}

/// `c = (1 - (a/2) cot(a/2)) / a^2` of `J^-1 = E + hat(phi)/2 + c hat(phi)^2`, for a rotation
/// vector of squared length `angle2` and the second value `fw` of [`Quat::log`]. Where the angle is
/// small the error of the quotient is large, but only products of `c` with squares of the vector
/// are used.
#[inline(always)]
pub(super) fn slope_of_log<S: Simd>(angle2: Lane<S>, fw: Lane<S>) -> Lane<S> {
    fw.lift(0.5).negate_mul_add(fw, fw.lift(1.0)) * (angle2 + fw.lift(1e-200)).recip()
}

/// Moment on the segment before a joint, world components: `J^-T m`, `m` the derivative of the
/// joint's energy by its rotation vector, in the frame `d` of the segment behind it.
#[inline(always)]
pub(super) fn moment<S: Simd>(phi: V3<S>, m: V3<S>, c: Lane<S>, d: [V3<S>; 3]) -> V3<S> {
    let turned = phi.cross(m);
    combine(d, phi.cross(turned).mul_add(c, m) - turned.scale(c.lift(0.5)))
}

/// What the second derivative of the logarithm adds to the Hessian of a joint with rotation vector
/// `phi` and moment `m`, both in the world: `sym(phi g^T) + beta E`.
///
/// From `log(exp(phi) exp(x)) = phi + J^-1 x + ...`, `J^-1 = E + hat(phi)/2 + c hat(phi)^2`, by
/// differentiating `J^-T m` and taking the symmetric part. `c` and its derivative by the squared
/// angle are needed beside a single `phi` here, so they come from their series in it.
#[inline(always)]
pub(super) fn log_hessian<S: Simd>(phi: V3<S>, m: V3<S>, x: Lane<S>) -> Sym<S> {
    let (mut c, mut slope) = (x.lift(LOG_SERIES[5]), x.lift(5.0 * LOG_SERIES[5]));
    for k in (0..5_u8).rev() {
        let term = LOG_SERIES[usize::from(k)];
        c = c.mul_add(x, x.lift(term));
        if k > 0 {
            slope = slope.mul_add(x, x.lift(f64::from(k) * term));
        }
    }
    let quarter = x.lift(0.25);
    let t = phi.cross(m);
    let p = phi.cross(t);
    let along = phi.dot(m);
    let c2 = c * c;
    let g = m.scale(quarter - c) - t.scale(c) + p.scale(slope + slope + c2) + phi.scale(c2 * along);
    let beta = along * (c - quarter - c2 * x);
    Sym::symmetric_outer(phi, g) + Sym::diagonal(beta)
}

/// Coefficients `|B_2k| / (2k)!` of `(1 - (a/2) cot(a/2)) / a^2` in powers of `a^2`.
const LOG_SERIES: [f64; 6] = [
    1.0 / 12.0,
    1.0 / 720.0,
    1.0 / 30_240.0,
    1.0 / 1_209_600.0,
    1.0 / 47_900_160.0,
    691.0 / 1_307_674_368_000.0,
];

/// The vector `d1 x + d2 y + d3 z` with the components `v` in the frame `d`.
#[inline(always)]
pub(super) fn combine<S: Simd>(d: [V3<S>; 3], v: V3<S>) -> V3<S> {
    d[0].mul_add(v.0[0], d[1].mul_add(v.0[1], d[2].scale(v.0[2])))
}

/// The matrix of the cross product with `v`.
#[inline(always)]
pub(super) fn hat<S: Simd>(v: V3<S>) -> M3<S> {
    let [x, y, z] = v.0;
    let o = x.lift(0.0);
    M3([V3([o, -z, y]), V3([z, o, -x]), V3([-y, x, o])])
}

/// Second variation of `-p d` under a rotation of `d`: `(p d) E - sym(p d^T)`; in definite lanes
/// its part along the director's own length, if positive.
#[inline(always)]
pub(super) fn director_hessian<S: Simd>(d: V3<S>, p: V3<S>, definite: Lane<S>) -> Sym<S> {
    let along = p.dot(d);
    let projected = d.scale(along.max(along.lift(0.0)));
    let mut used = p;
    used += (projected - p).scale(definite);
    Sym::diagonal(used.dot(d)) - Sym::symmetric_outer(used, d)
}

/// A vector that turns the directors of one frame into those of another, but for terms of higher
/// order in it: the axis, with the sine of the angle.
#[inline(always)]
pub(super) fn turn<S: Simd>(from: [V3<S>; 3], to: [V3<S>; 3]) -> V3<S> {
    let sum = from[0].cross(to[0]) + from[1].cross(to[1]) + from[2].cross(to[2]);
    sum.scale(sum.0[0].lift(0.5))
}

/// Moment, energy and Hessian of one joint.
pub(super) struct JointEffect<S: Simd> {
    /// Moment on the segment before the joint, N m, world.
    pub(super) moment: V3<S>,
    pub(super) energy: Lane<S>,
    pub(super) hessian: Sym<S>,
}

impl<S: Simd> JointEffect<S> {
    #[inline(always)]
    pub(super) fn none(simd: S) -> Self {
        let (zero, v) = (Lane::splat(simd, 0.0), V3::splat(simd, 0.0));
        let sym = Sym::diagonal(zero);
        Self { moment: v, energy: zero, hessian: sym }
    }
}
