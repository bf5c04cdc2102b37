//! Values of the harmonics at points, and expansions that are the gradient of another.

use super::tables::{HarmonicTables, count};
use pulp::{Scalar, Simd};
use rapunzel_lanes::Lane;

/// Values of all `R_nm` up to degree `order` at `point`, a point in each lane, into `out`.
///
/// Cost: 3 operations a harmonic.
#[inline(always)]
pub(crate) fn regular<S: Simd>(
    tables: &HarmonicTables,
    order: usize,
    [x, y, z]: [Lane<S>; 3],
    out: &mut [S::f64s],
) {
    let r2 = x.mul_add(x, y.mul_add(y, z * z));
    let zero = x.lift(0.0);
    let [mut cosine, mut sine] = [x.lift(1.0), zero];
    for (m, (steps, diagonal)) in tables.steps.iter().zip(&tables.diagonal).enumerate() {
        if m > order {
            return;
        }
        // R_mm from R_(m-1)(m-1), as the product of complex numbers with x + i y.
        if m > 0 {
            let (c, s, scale) = (cosine, sine, x.lift(*diagonal));
            let [x, y] = [x * scale, y * scale];
            cosine = c * x - s * y;
            sine = c.mul_add(y, s * x);
        }
        let [mut last, mut now] = [[zero; 2], [cosine, sine]];
        // Recurrence of the Legendre functions in the degree, n here from m on.
        for (n, step) in steps[..=order - m].iter().enumerate() {
            if n > 0 {
                let up = z.lift(step.z_factor) * z;
                let down = z.lift(-step.r_factor) * r2;
                let mut next = now;
                for k in 0..2 {
                    next[k] = up.mul_add(now[k], down * last[k]);
                }
                [last, now] = [now, next];
            }
            // For m = 0 both places are one, and the cosine is written last.
            out[step.places[1]] = now[1].value;
            out[step.places[0]] = now[0].value;
        }
    }
}

/// Values of all `R_nm` up to degree `order` at one `point`, into `out`.
pub(crate) fn regular_at(tables: &HarmonicTables, order: usize, point: [f64; 3], out: &mut [f64]) {
    regular(tables, order, point.map(|x| Lane::splat(Scalar::new(), x)), out);
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
