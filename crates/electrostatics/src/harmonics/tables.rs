//! Constants of the harmonics, made once for the highest order.

use super::MAX_ORDER;
use std::f64::consts::SQRT_2;
use std::sync::OnceLock;

/// Coefficients of degree 0 up to `order`.
pub(crate) const fn count(order: usize) -> usize {
    (order + 1) * (order + 1)
}

/// Places of the coefficients with `cos(m phi)` and `sin(m phi)` of degree `n`, from the first
/// coefficient of degree 0; for `m = 0`, where there is no sine, both are the cosine.
///
/// A degree holds four runs, in this order: cosines of even m, sines of odd m, cosines of odd m,
/// sines of even m. They are even or odd in x and y, so an exchange of y and z maps run to run.
pub(crate) const fn index(n: usize, m: usize) -> [usize; 2] {
    let (first, evens, odds) = (n * n, n / 2 + 1, n.div_ceil(2));
    let k = m / 2;
    match m {
        0 => [first, first],
        _ if m.is_multiple_of(2) => [first + k, first + evens + 2 * odds + k - 1],
        _ => [first + evens + odds + k, first + evens + k],
    }
}

/// Step of the recurrence for `R_nm` in n, `R_n = z_factor z R_(n-1) - r_factor r^2 R_(n-2)`.
pub(super) struct RecurrenceStep {
    /// Places of the cosine and the sine that the step makes, as [`index`] tells them.
    pub(super) places: [usize; 2],
    /// Factor of `z R_(n-1)`.
    pub(super) z_factor: f64,
    /// Factor of `r^2 R_(n-2)`, which is subtracted.
    pub(super) r_factor: f64,
}

/// Share of one coefficient of an expansion in a coefficient of one of its derivatives.
pub(super) struct Slope {
    /// Place of the coefficient of the expansion.
    pub(super) from: usize,
    /// Place of the coefficient of the derivative.
    pub(super) to: usize,
    /// Axis of the derivative: 1 for x, 2 for y, 3 for z.
    pub(super) axis: usize,
    /// Factor of the coefficient, for an expansion whose lengths are not scaled.
    pub(super) factor: f64,
}

/// Constants of the harmonics and of their derivatives, for degrees up to [`MAX_ORDER`].
pub(crate) struct HarmonicTables {
    /// Factors of the recurrence in m: `R_mm = diagonal[m] (x + i y) R_(m-1)(m-1)`.
    pub(super) diagonal: Vec<f64>,
    /// Steps of the recurrence in n, as `steps[m][n - m]`.
    pub(super) steps: Vec<Vec<RecurrenceStep>>,
    /// Shares of the coefficients of each degree in the derivatives of an expansion.
    pub(super) slopes: Vec<Vec<Slope>>,
}

impl HarmonicTables {
    /// Tables of this program, made at the first call.
    pub(crate) fn get() -> &'static Self {
        static TABLES: OnceLock<HarmonicTables> = OnceLock::new();
        TABLES.get_or_init(Self::new)
    }

    /// Tables for degrees up to [`MAX_ORDER`].
    fn new() -> Self {
        let factorials = factorials();
        let step = |m: usize, n: usize| {
            let [n2, m2] = [n * n, m * m].map(|k| k as f64);
            let below = (n as f64 - 1.0).powi(2) - m2;
            RecurrenceStep {
                places: index(n, m),
                z_factor: if n > m { (2.0 * n as f64 - 1.0) / (n2 - m2).sqrt() } else { 0.0 },
                r_factor: if n > m + 1 { (below / (n2 - m2)).sqrt() } else { 0.0 },
            }
        };
        // `R_nm` over the unscaled harmonic.
        let norm = |n: usize, m: usize| {
            (factorials[n - m] * factorials[n + m]).sqrt() * if m > 0 { SQRT_2 } else { 1.0 }
        };
        let orders = || 0..=MAX_ORDER;
        Self {
            diagonal: orders().map(diagonal).collect(),
            steps: orders().map(|m| (m..=MAX_ORDER).map(|n| step(m, n)).collect()).collect(),
            slopes: orders().map(|n| slopes(n, norm)).collect(),
        }
    }
}

/// Shares of the coefficients of degree `n` in the derivatives; `norm(n, m)` is `R_nm` over the
/// unscaled harmonic. The derivatives of the unscaled harmonic `(n, m)` are
/// `d/dz (n, m) = (n-1, m)`, and `d/dx` and `d/dy` are half the difference and half the sum of
/// `(n-1, m-1)` and `(n-1, m+1)`; a part is its cosine (0) or its sine (1).
fn slopes(n: usize, norm: impl Fn(usize, usize) -> f64) -> Vec<Slope> {
    let mut slopes = Vec::new();
    for m in (0..=n).filter(|_| n > 0) {
        for (part, &from) in index(n, m)[..if m > 0 { 2 } else { 1 }].iter().enumerate() {
            let mut add = |axis: usize, k: usize, part: usize, factor: f64| {
                if k < n && (k > 0 || part == 0) {
                    let factor = factor * norm(n, m) / norm(n - 1, k);
                    slopes.push(Slope { from, to: index(n - 1, k)[part], axis, factor });
                }
            };
            add(3, m, part, 1.0);
            if m == 0 {
                add(1, 1, 0, -1.0);
                add(2, 1, 1, -1.0);
                continue;
            }
            let turned = if part == 0 { -0.5 } else { 0.5 };
            add(1, m - 1, part, 0.5);
            add(1, m + 1, part, -0.5);
            add(2, m + 1, 1 - part, turned);
            add(2, m - 1, 1 - part, turned);
        }
    }
    slopes
}

/// Factorials of 0 up to `2 MAX_ORDER`.
pub(super) fn factorials() -> Vec<f64> {
    let mut factorials = vec![1.0];
    for k in 1..=2 * MAX_ORDER {
        factorials.push(factorials[k - 1] * k as f64);
    }
    factorials
}

/// Ratio of `R_mm` to `(x + i y) R_(m-1)(m-1)`.
fn diagonal(m: usize) -> f64 {
    let m = m as f64;
    if m < 2.0 { 1.0 } else { ((2.0 * m - 1.0) / (2.0 * m)).sqrt() }
}
