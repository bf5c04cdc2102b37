//! Point charges and straight charged lines, eight lines or eight points in the lanes.

/// Lanes.
pub(super) const LANES: usize = 8;

/// Eight numbers.
pub(super) type Lanes = [f64; LANES];

/// Eight vectors.
pub(super) type Vectors = [Lanes; 3];

/// Lines from `start` along the unit vector `tangent`.
#[derive(Clone, Copy)]
pub(super) struct Line {
    pub(super) start: Vectors,
    pub(super) tangent: Vectors,
    pub(super) length: Lanes,
}

/// What the charges of a pair of a point and a line do for a product of charges of 1, with the
/// kernel `1/sqrt(r^2 + softening)`.
pub(super) struct Action {
    /// Their energy.
    pub(super) energy: Lanes,
    /// The force on the point.
    pub(super) point: Vectors,
    /// The part of the force on the line that its end takes; its start takes the rest.
    pub(super) end: Vectors,
}

/// Eight pairs of points and lines, in closed form.
///
/// With s the distance along the line from its start to the foot of the point, and p the
/// perpendicular: the integrals over the line of `1/r`, `1/r^3`, `v/r^3` and `v^2/r^3`, where
/// v is counted from the foot, are a logarithm L, `J0`, `J1` and `L - rho^2 J0`. `J0` is written
/// so that it does not cancel beyond the ends.
#[inline(always)]
pub(super) fn act(point: &Vectors, line: &Line, softening: &Lanes) -> Action {
    let zero = [0.0; LANES];
    let mut out = Action { energy: zero, point: [zero; 3], end: [zero; 3] };
    let mut ratio = zero;
    let mut parts = [zero; 5];
    let mut offsets = [zero; 3];
    for k in 0..LANES {
        let d = [0, 1, 2].map(
            #[inline(always)]
            |c| point[c][k] - line.start[c][k],
        );
        let t = [line.tangent[0][k], line.tangent[1][k], line.tangent[2][k]];
        let length = line.length[k];
        let s = d[0] * t[0] + d[1] * t[1] + d[2] * t[2];
        let p = [d[0] - s * t[0], d[1] - s * t[1], d[2] - s * t[2]];
        let rho2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + softening[k];
        let e = s - length;
        let [ra, rb] = [(s * s + rho2).sqrt(), (e * e + rho2).sqrt()];
        let beyond = s * e > 0.0;
        let numerator = if beyond { length * (s + e) } else { s * rb - e * ra };
        let denominator = if beyond { s * rb + e * ra } else { rho2 };
        let j0 = numerator / (denominator * (ra * rb));
        let j1 = (rb - ra) / (ra * rb);
        ratio[k] = (ra + rb + length) / (ra + rb - length);
        parts[0][k] = j0;
        parts[1][k] = j1;
        parts[2][k] = s;
        parts[3][k] = rho2;
        for c in 0..3 {
            offsets[c][k] = p[c];
        }
    }
    ln(&mut ratio);
    for k in 0..LANES {
        let [j0, j1, s, rho2] = [parts[0][k], parts[1][k], parts[2][k], parts[3][k]];
        let inverse = 1.0 / line.length[k];
        out.energy[k] = ratio[k] * inverse;
        let across = (j1 + s * j0) * inverse * inverse;
        let along = (ratio[k] - rho2 * j0 + s * j1) * inverse * inverse;
        for c in 0..3 {
            let [p, t] = [offsets[c][k], line.tangent[c][k]];
            out.point[c][k] = (p * j0 - t * j1) * inverse;
            out.end[c][k] = t * along - p * across;
        }
    }
    out
}

/// Natural logarithms of positive normal numbers, to some units in the last place.
#[inline(always)]
fn ln(x: &mut Lanes) {
    const MANTISSA: u64 = (1 << 52) - 1;
    const ONE: u64 = 1023 << 52;
    // 2^52 as bits: adding a small integer to these bits adds it to the number.
    const SHIFTED: u64 = 0x4330_0000_0000_0000;
    for x in x {
        // Mantissas above sqrt(2) are halved.
        let bits = x.to_bits() + (ONE - std::f64::consts::FRAC_1_SQRT_2.to_bits());
        let exponent = f64::from_bits((bits >> 52) | SHIFTED) - 4_503_599_627_370_496.0 - 1023.0;
        let m = f64::from_bits((bits & MANTISSA) + std::f64::consts::FRAC_1_SQRT_2.to_bits());
        let f = (m - 1.0) / (m + 1.0);
        let w = f * f;
        let mut sum = 1.0 / 21.0;
        for n in (1..=9).rev() {
            sum = sum * w + 1.0 / (2 * n + 1) as f64;
        }
        *x = exponent * std::f64::consts::LN_2 + 2.0 * f * (sum * w + 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::gauss_legendre;

    #[test]
    fn logarithms_are_exact() {
        let mut x: Lanes = [1.0, 1.0 + 1e-9, 0.7, 1.4142, 2.0, 1e-200, 3e17, 12.5];
        let exact = x.map(f64::ln);
        ln(&mut x);
        for (x, exact) in x.iter().zip(exact) {
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
                let line = Line {
                    start: [[0.0; 8]; 3],
                    tangent: [[0.0; 8], [0.0; 8], [1.0; 8]],
                    length: [1.25; 8],
                };
                let action = act(&x.map(|x| [x; 8]), &line, &[softening; 8]);
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
                let actual = [&[action.energy][..], &action.point, &action.end].concat();
                for (a, s) in actual.iter().zip(sums) {
                    assert!((a[3] - s).abs() < 1e-9 * s.abs().max(0.1), "{x:?}: {} not {s}", a[3]);
                }
            }
        }
    }
}
