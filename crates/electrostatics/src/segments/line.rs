//! Point charges and straight charged lines, one pair in each lane.

use pulp::Simd;

/// Vectors, one in each lane.
pub(super) type Vectors<S> = [<S as Simd>::f64s; 3];

/// Lines from `start` along the unit vector `tangent`.
#[derive(Clone, Copy)]
pub(super) struct Line<S: Simd> {
    pub(super) start: Vectors<S>,
    pub(super) tangent: Vectors<S>,
    pub(super) length: S::f64s,
}

/// What the charges of a pair of a point and a line do for a product of charges of 1, with the
/// kernel `1/sqrt(r^2 + softening)`.
pub(super) struct Action<S: Simd> {
    /// Their energy.
    pub(super) energy: S::f64s,
    /// The force on the point.
    pub(super) point: Vectors<S>,
    /// The part of the force on the line that its end takes; its start takes the rest.
    pub(super) end: Vectors<S>,
}

#[inline(always)]
pub(super) fn dot<S: Simd>(simd: S, a: &Vectors<S>, b: &Vectors<S>) -> S::f64s {
    let sum = simd.mul_add_e_f64s(a[1], b[1], simd.mul_f64s(a[0], b[0]));
    simd.mul_add_e_f64s(a[2], b[2], sum)
}

/// Pairs of points and lines, in closed form.
///
/// With s the distance along the line from its start to the foot of the point, and p the
/// perpendicular: the integrals over the line of `1/r`, `1/r^3`, `v/r^3` and `v^2/r^3`, where
/// v is counted from the foot, are a logarithm L, `J0`, `J1` and `L - rho^2 J0`. `J0` is written
/// so that it does not cancel beyond the ends.
#[inline(always)]
pub(super) fn act<S: Simd>(
    simd: S,
    point: &Vectors<S>,
    line: &Line<S>,
    softening: S::f64s,
) -> Action<S> {
    let (t, length, one) = (&line.tangent, line.length, simd.splat_f64s(1.0));
    let mut p = *point;
    for c in 0..3 {
        p[c] = simd.sub_f64s(p[c], line.start[c]);
    }
    let s = dot(simd, &p, t);
    for c in 0..3 {
        p[c] = simd.negate_mul_add_e_f64s(s, t[c], p[c]);
    }
    let rho2 = simd.add_f64s(dot(simd, &p, &p), softening);
    let e = simd.sub_f64s(s, length);
    let ra = simd.sqrt_f64s(simd.mul_add_e_f64s(s, s, rho2));
    let rb = simd.sqrt_f64s(simd.mul_add_e_f64s(e, e, rho2));
    let beyond = simd.greater_than_f64s(simd.mul_f64s(s, e), simd.splat_f64s(0.0));
    let [cross, era] = [simd.mul_f64s(s, rb), simd.mul_f64s(e, ra)];
    let outer = simd.mul_f64s(length, simd.add_f64s(s, e));
    let numerator = simd.select_f64s(beyond, outer, simd.sub_f64s(cross, era));
    let denominator = simd.select_f64s(beyond, simd.add_f64s(cross, era), rho2);
    let rarb = simd.mul_f64s(ra, rb);
    // One division for the inverses of ra rb and of the denominator.
    let both = simd.div_f64s(one, simd.mul_f64s(denominator, rarb));
    let j0 = simd.mul_f64s(numerator, both);
    let j1 = simd.mul_f64s(simd.sub_f64s(rb, ra), simd.mul_f64s(both, denominator));
    let sum = simd.add_f64s(ra, rb);
    let log = ln(simd, simd.div_f64s(simd.add_f64s(sum, length), simd.sub_f64s(sum, length)));
    let inverse = simd.div_f64s(one, length);
    let square = simd.mul_f64s(inverse, inverse);
    let across = simd.mul_f64s(simd.mul_add_e_f64s(s, j0, j1), square);
    let along = simd.mul_add_e_f64s(s, j1, simd.negate_mul_add_e_f64s(rho2, j0, log));
    let along = simd.mul_f64s(along, square);
    let [j0, j1] = [simd.mul_f64s(j0, inverse), simd.mul_f64s(j1, inverse)];
    let [mut force, mut end] = [p; 2];
    for c in 0..3 {
        force[c] = simd.negate_mul_add_e_f64s(t[c], j1, simd.mul_f64s(p[c], j0));
        end[c] = simd.negate_mul_add_e_f64s(p[c], across, simd.mul_f64s(t[c], along));
    }
    Action { energy: simd.mul_f64s(log, inverse), point: force, end }
}

/// Natural logarithms of positive normal numbers, to some units in the last place.
#[inline(always)]
fn ln<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    const MANTISSA: u64 = (1 << 52) - 1;
    const ONE: u64 = 1023 << 52;
    const ROOT: u64 = std::f64::consts::FRAC_1_SQRT_2.to_bits();
    // 2^52 as bits: adding a small integer to these bits adds it to the number.
    const SHIFTED: u64 = 0x4330_0000_0000_0000;
    let [mut exponents, mut mantissas] = [[0_u64; 8]; 2];
    let bits: &[u64] = pulp::bytemuck::cast_slice(std::slice::from_ref(&x));
    for ((x, exponent), mantissa) in bits.iter().zip(&mut exponents).zip(&mut mantissas) {
        // Mantissas run from sqrt(1/2) to sqrt(2).
        let bits = x + (ONE - ROOT);
        *exponent = (bits >> 52) | SHIFTED;
        *mantissa = (bits & MANTISSA) + ROOT;
    }
    let exponent = S::as_simd_f64s(pulp::bytemuck::cast_slice(&exponents)).0[0];
    let m = S::as_simd_f64s(pulp::bytemuck::cast_slice(&mantissas)).0[0];
    let exponent = simd.sub_f64s(exponent, simd.splat_f64s(4_503_599_627_370_496.0 + 1023.0));
    let one = simd.splat_f64s(1.0);
    let f = simd.div_f64s(simd.sub_f64s(m, one), simd.add_f64s(m, one));
    let w = simd.mul_f64s(f, f);
    let mut sum = simd.splat_f64s(1.0 / 21.0);
    for n in (0..=9).rev() {
        sum = simd.mul_add_e_f64s(sum, w, simd.splat_f64s(1.0 / (2 * n + 1) as f64));
    }
    let fraction = simd.mul_f64s(simd.add_f64s(f, f), sum);
    simd.mul_add_e_f64s(exponent, simd.splat_f64s(std::f64::consts::LN_2), fraction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::gauss_legendre;

    #[test]
    fn logarithms_are_exact() {
        let x = [1.0, 1.0 + 1e-9, 0.7, 1.414, 2.0, 1e-200, 3e17, 12.5];
        for x in x {
            let (exact, x) = (f64::ln(x), ln(pulp::Scalar::new(), x));
            assert!((x - exact).abs() <= 4e-16 * exact.abs().max(0.3), "{x} is not {exact}");
        }
    }

    /// The closed form against quadrature in 2000 intervals, beside, on and beyond the line.
    #[test]
    fn closed_forms_are_the_integrals() {
        let rule = gauss_legendre(4);
        let places = [[0.3, 0.2, 0.1], [0.0, 0.0, 1.7], [0.01, 0.0, -0.5], [0.0, 0.03, 0.5]];
        for x in places {
            for softening in [1e-3, 1e-12] {
                let simd = pulp::Scalar::new();
                let line = Line { start: [0.0; 3], tangent: [0.0, 0.0, 1.0], length: 1.25 };
                let action = act(simd, &x, &line, softening);
                let mut sums = [0.0; 7];
                for k in 0..2000 {
                    for [node, weight] in &rule {
                        let u = (f64::from(k) + 0.5 + 0.5 * node) / 2000.0;
                        let d = [x[0], x[1], x[2] - 1.25 * u];
                        let r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + softening;
                        let w = 0.5 * weight / 2000.0;
                        sums[0] += w / r2.sqrt();
                        for c in 0..3 {
                            sums[1 + c] += w * d[c] / r2.powf(1.5);
                            sums[4 + c] -= w * u * d[c] / r2.powf(1.5);
                        }
                    }
                }
                let actual = [[action.energy].as_slice(), &action.point, &action.end].concat();
                for (a, s) in actual.iter().zip(sums) {
                    assert!((a - s).abs() < 1e-9 * s.abs().max(0.1), "{x:?}: {a} not {s}");
                }
            }
        }
    }
}
