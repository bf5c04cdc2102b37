//! Constants of the harmonics, made once for the highest order.

use super::MAX_ORDER;
use crate::quadrature::gauss_legendre;
use rapunzel_lanes::{Real, Ways};
use std::f64::consts::{PI, SQRT_2};
use std::ops::Range;
use std::sync::OnceLock;

/// Coefficients of degree 0 up to `order`.
pub(crate) const fn count(order: usize) -> usize {
    (order + 1) * (order + 1)
}

/// Where the coefficients with `cos(m phi)` and `sin(m phi)` of degree `n` stand; for `m = 0`, where
/// there is no sine, both are the cosine.
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

/// The four runs of degree `n`, from its first coefficient, and which run each becomes when y and z are exchanged.
fn runs(n: usize) -> [(Range<usize>, usize); 4] {
    let (evens, odds) = (n / 2 + 1, n.div_ceil(2));
    let ends = [0, evens, evens + odds, evens + 2 * odds, 2 * n + 1];
    let partner = if n.is_multiple_of(2) { [0, 1, 3, 2] } else { [1, 0, 2, 3] };
    [0, 1, 2, 3].map(|k| (ends[k]..ends[k + 1], partner[k]))
}

/// What the exchange of y and z makes of one run.
pub(super) struct Swap<E> {
    pub(super) from: Range<usize>,
    pub(super) to: Range<usize>,
    pub(super) matrix: Matrix<E, 8>,
}

/// A matrix in blocks of rows, column by column.
pub(super) struct Matrix<E, const ROWS: usize> {
    columns: usize,
    blocks: Vec<[E; ROWS]>,
}

impl<E: Real, const ROWS: usize> Matrix<E, ROWS> {
    fn new(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let mut blocks = Vec::new();
        for first in (0..rows).step_by(ROWS) {
            for column in 0..columns {
                let entry =
                    |r| E::from_f64(if first + r < rows { entry(first + r, column) } else { 0.0 });
                blocks.push(std::array::from_fn(entry));
            }
        }
        Self { columns, blocks }
    }

    /// The columns of the rows `ROWS block..`.
    #[inline(always)]
    pub(super) fn block(&self, block: usize) -> &[[E; ROWS]] {
        &self.blocks[block * self.columns..(block + 1) * self.columns]
    }
}

/// One step of the recurrence for `R_nm` in n, and the place of its results.
pub(super) struct Step {
    pub(super) places: [usize; 2],
    /// `R_n = z_factor z R_(n-1) - r_factor r^2 R_(n-2)`.
    pub(super) z_factor: f64,
    pub(super) r_factor: f64,
}

/// A coefficient's share of a coefficient of one derivative.
pub(super) struct Slope {
    pub(super) from: usize,
    pub(super) to: usize,
    /// 1 for x, 2 for y, 3 for z.
    pub(super) axis: usize,
    pub(super) factor: f64,
}

/// Constants of the harmonics.
pub(crate) struct Tables {
    /// `R_mm = diagonal[m] (x + i y) R_(m-1)(m-1)`.
    pub(super) diagonal: Vec<f64>,
    /// `steps[m][n - m]`.
    pub(super) steps: Vec<Vec<Step>>,
    /// What each degree adds to the derivatives of an expansion.
    pub(super) slopes: Vec<Vec<Slope>>,
}

impl Tables {
    /// The tables; made at the first call.
    pub(crate) fn get() -> &'static Self {
        static TABLES: OnceLock<Tables> = OnceLock::new();
        TABLES.get_or_init(Self::new)
    }

    fn new() -> Self {
        let factorials = factorials();
        let step = |m: usize, n: usize| {
            let [n2, m2] = [n * n, m * m].map(|k| k as f64);
            let below = (n as f64 - 1.0).powi(2) - m2;
            Step {
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

/// What degree `n` adds to the derivatives. Those of the unscaled harmonic `(n, m)` are
/// `d/dz (n, m) = (n-1, m)`, and `d/dx` and `d/dy` are half the difference and half the sum of
/// `(n-1, m-1)` and `(n-1, m+1)`; a part is its cosine (0) or its sine.
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

fn factorials() -> Vec<f64> {
    let mut factorials = vec![1.0];
    for k in 1..=2 * MAX_ORDER {
        factorials.push(factorials[k - 1] * k as f64);
    }
    factorials
}

/// Matrices that move expansions.
pub(crate) struct Moves<E> {
    /// Where cosine and sine of `[n][m]` stand among those of the degree n.
    pub(super) places: Vec<Vec<[usize; 2]>>,
    /// The exchange of y and z, for each degree.
    pub(super) swaps: Vec<[Swap<E>; 4]>,
    /// `far[m]` takes a multipole along z to a local expansion: rows n - m, columns l - m.
    pub(super) far: Vec<Matrix<E, 4>>,
    /// `shifts[m][n - m][l - m]` moves a multipole along z, its transpose a local expansion.
    pub(super) shifts: Vec<Vec<Vec<E>>>,
}

/// A type of coefficients, of single or double precision.
pub(crate) trait Coefficient: Ways {
    /// The constants that move expansions, which are made at the first call.
    fn moves() -> &'static Moves<Self>;
}

macro_rules! coefficient {
    ($real:ident) => {
        impl Coefficient for $real {
            fn moves() -> &'static Moves<Self> {
                static MOVES: OnceLock<Moves<$real>> = OnceLock::new();
                MOVES.get_or_init(Moves::new)
            }
        }
    };
}
coefficient!(f32);
coefficient!(f64);

impl<E: Real> Moves<E> {
    /// Takes some milliseconds.
    pub(crate) fn new() -> Self {
        let factorials = factorials();
        let root = |n: usize, m: usize| (factorials[n - m] * factorials[n + m]).sqrt();
        let shift = |m: usize, n: usize, l: usize| {
            E::from_f64(if l > n { 0.0 } else { root(n, m) / (root(l, m) * factorials[n - l]) })
        };
        let far = |m: usize, n: usize, l: usize| {
            let sign = if (n + m).is_multiple_of(2) { 1.0 } else { -1.0 };
            sign * (factorials[n + l] / root(n, m)) / root(l, m)
        };
        let orders = || 0..=MAX_ORDER;
        Self {
            places: orders()
                .map(|n| (0..=n).map(|m| index(n, m).map(|place| place - n * n)).collect())
                .collect(),
            swaps: swaps(Tables::get()),
            far: orders()
                .map(|m| {
                    let size = MAX_ORDER + 1 - m;
                    Matrix::new(size, size, |n, l| far(m, n + m, l + m))
                })
                .collect(),
            shifts: orders()
                .map(|m| {
                    let row = |n| (m..=MAX_ORDER).map(|l| shift(m, n, l)).collect();
                    (m..=MAX_ORDER).map(row).collect()
                })
                .collect(),
        }
    }
}

fn diagonal(m: usize) -> f64 {
    let m = m as f64;
    if m < 2.0 { 1.0 } else { ((2.0 * m - 1.0) / (2.0 * m)).sqrt() }
}

/// The matrices of the exchange of y and z, as integrals over the sphere of the product of one
/// harmonic and another exchanged. All of those are even in x, y and z: an octant is enough.
fn swaps<E: Real>(tables: &Tables) -> Vec<[Swap<E>; 4]> {
    let azimuths = MAX_ORDER / 2 + 1;
    let mut samples = Vec::new();
    for [z, weight] in gauss_legendre(2 * azimuths).into_iter().filter(|[z, _]| *z > 0.0) {
        for j in 0..azimuths {
            let phi = 0.5 * PI * (j as f64 + 0.5) / azimuths as f64;
            let s = (1.0 - z * z).sqrt();
            let values = |x: [f64; 3]| {
                let mut out = vec![0.0; count(MAX_ORDER)];
                super::regular(pulp::Scalar::new(), tables, MAX_ORDER, x, &mut out);
                out
            };
            let [x, y] = [s * phi.cos(), s * phi.sin()];
            samples.push((weight / azimuths as f64, values([x, y, z]), values([x, z, y])));
        }
    }
    let matrices = |n: usize| {
        let runs = runs(n);
        runs.clone().map(|(to, partner)| {
            let from = runs[partner].0.clone();
            let matrix = Matrix::new(to.len(), from.len(), |row, column| {
                let term = |(w, y, swapped): &(f64, Vec<f64>, Vec<f64>)| {
                    w * swapped[n * n + to.start + row] * y[n * n + from.start + column]
                };
                (2 * n + 1) as f64 * samples.iter().map(term).sum::<f64>()
            });
            Swap { from, to, matrix }
        })
    };
    (0..=MAX_ORDER).map(matrices).collect()
}
