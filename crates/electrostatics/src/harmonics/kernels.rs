//! Values of the harmonics at points, and expansions that are the gradient of another.

use super::tables::{HarmonicTables, count};
use pulp::Simd;

/// Values of all `R_nm` up to degree `order` at `point`, a point in each lane, into `out`.
///
/// Cost: 3 operations a harmonic.
#[inline(always)]
pub(crate) fn regular<S: Simd>(
    simd: S,
    tables: &HarmonicTables,
    order: usize,
    [x, y, z]: [S::f64s; 3],
    out: &mut [S::f64s],
) {
    let r2 = simd.mul_add_e_f64s(y, y, simd.mul_f64s(z, z));
    let r2 = simd.mul_add_e_f64s(x, x, r2);
    let zero = simd.splat_f64s(0.0);
    let [mut cosine, mut sine] = [simd.splat_f64s(1.0), zero];
    for (m, (steps, diagonal)) in tables.steps.iter().zip(&tables.diagonal).enumerate() {
        if m > order {
            return;
        }
        // R_mm from R_(m-1)(m-1), as the product of complex numbers with x + i y.
        if m > 0 {
            let (c, s, scale) = (cosine, sine, simd.splat_f64s(*diagonal));
            let [x, y] = [simd.mul_f64s(x, scale), simd.mul_f64s(y, scale)];
            cosine = simd.sub_f64s(simd.mul_f64s(c, x), simd.mul_f64s(s, y));
            sine = simd.mul_add_e_f64s(c, y, simd.mul_f64s(s, x));
        }
        let [mut last, mut now] = [[zero; 2], [cosine, sine]];
        // Recurrence of the Legendre functions in the degree, n here from m on.
        for (n, step) in steps[..=order - m].iter().enumerate() {
            if n > 0 {
                let up = simd.mul_f64s(simd.splat_f64s(step.z_factor), z);
                let down = simd.mul_f64s(simd.splat_f64s(-step.r_factor), r2);
                let mut next = now;
                for k in 0..2 {
                    next[k] = simd.mul_add_e_f64s(up, now[k], simd.mul_f64s(down, last[k]));
                }
                [last, now] = [now, next];
            }
            // For m = 0 both places are one, and the cosine is written last.
            out[step.places[1]] = now[1];
            out[step.places[0]] = now[0];
        }
    }
}

/// Local expansions of a potential and of its three derivatives.
#[derive(Debug, Default)]
pub(crate) struct Gradient {
    /// Coefficients of the potential, each with those of the derivatives by x, y and z at the same
    /// place.
    pub(crate) terms: Vec<[f64; 4]>,
}

impl Gradient {
    /// Sets the terms from the coefficients `local` (degree up to `order`, lengths over `scale`, m)
    /// of the potential.
    pub(crate) fn set(&mut self, tables: &HarmonicTables, order: usize, scale: f64, local: &[f64]) {
        self.terms.clear();
        self.terms.extend(local[..count(order)].iter().map(|&c| [c, 0.0, 0.0, 0.0]));
        let inverse = 1.0 / scale;
        for slope in tables.slopes[..=order].iter().flatten() {
            self.terms[slope.to][slope.axis] += local[slope.from] * inverse * slope.factor;
        }
    }
}
