//! Constants that move expansions, made once for the highest degree.

use super::MAX_ORDER;
use super::kernels::regular_at;
use super::tables::{HarmonicTables, count, factorials, index};
use rapunzel_fiber::quadrature::gauss_legendre;
use rapunzel_lanes::{Real, Ways};
use std::f64::consts::PI;
use std::ops::Range;
use std::sync::OnceLock;

/// The four runs of the coefficients of degree `n`, as ranges from the first coefficient of the
/// degree, and for each the run that it becomes when y and z are exchanged.
fn runs(n: usize) -> [(Range<usize>, usize); 4] {
    let (evens, odds) = (n / 2 + 1, n.div_ceil(2));
    let ends = [0, evens, evens + odds, evens + 2 * odds, 2 * n + 1];
    let partner = if n.is_multiple_of(2) { [0, 1, 3, 2] } else { [1, 0, 2, 3] };
    [0, 1, 2, 3].map(|k| (ends[k]..ends[k + 1], partner[k]))
}

/// The exchange of y and z for one run of coefficients of one degree.
pub(super) struct Swap<E> {
    /// Run that is taken, from the first coefficient of the degree.
    pub(super) from: Range<usize>,
    /// Run that is made, from the first coefficient of the degree.
    pub(super) to: Range<usize>,
    /// Matrix with a row for each coefficient that is made and a column for each that is taken.
    pub(super) matrix: Matrix<E, 8>,
}

/// A matrix in blocks of rows, column by column.
pub(super) struct Matrix<E, const ROWS: usize> {
    columns: usize,
    blocks: Vec<[E; ROWS]>,
}

impl<E: Real, const ROWS: usize> Matrix<E, ROWS> {
    /// Matrix of `rows` rows and `columns` columns with the values of `entry(row, column)`; the
    /// last block is filled up with zeros.
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

    /// Columns of the rows from `ROWS * block` on, `ROWS` numbers each.
    #[inline(always)]
    pub(super) fn block(&self, block: usize) -> &[[E; ROWS]] {
        &self.blocks[block * self.columns..(block + 1) * self.columns]
    }
}

/// Matrices that move expansions.
pub(crate) struct TranslationTables<E> {
    /// Places of the cosine and the sine of `[n][m]`, from the first coefficient of the degree n.
    pub(super) places: Vec<Vec<[usize; 2]>>,
    /// Exchange of y and z for the four runs of each degree.
    pub(super) swaps: Vec<[Swap<E>; 4]>,
    /// Matrix `far[m]` that takes a multipole along z to a local expansion: rows n - m, columns l -
    /// m.
    pub(super) far: Vec<Matrix<E, 4>>,
    /// Entries `shifts[m][n - m][l - m]` of the matrix that moves a multipole along z; the
    /// transpose moves a local expansion.
    pub(super) shifts: Vec<Vec<Vec<E>>>,
}

/// A type of coefficients, of single or double precision.
pub(crate) trait Coefficient: Ways {
    /// The constants that move expansions, which are made at the first call.
    fn moves() -> &'static TranslationTables<Self>;
}

macro_rules! coefficient {
    ($real:ident) => {
        impl Coefficient for $real {
            fn moves() -> &'static TranslationTables<Self> {
                static MOVES: OnceLock<TranslationTables<$real>> = OnceLock::new();
                MOVES.get_or_init(TranslationTables::new)
            }
        }
    };
}
coefficient!(f32);
coefficient!(f64);

impl<E: Real> TranslationTables<E> {
    /// All constants up to [`MAX_ORDER`]. Cost: some milliseconds.
    pub(crate) fn new() -> Self {
        let factorials = factorials();
        let root = |n: usize, m: usize| (factorials[n - m] * factorials[n + m]).sqrt();
        // M2M along z: an entry is `sqrt((n-m)! (n+m)!/((l-m)! (l+m)!))/(n-l)!`, the binomial sum
        // of the translated harmonics in this normalization.
        let shift = |m: usize, n: usize, l: usize| {
            E::from_f64(if l > n { 0.0 } else { root(n, m) / (root(l, m) * factorials[n - l]) })
        };
        // M2L along z: an entry is `(-1)^(n+m) (n+l)!/sqrt((n-m)! (n+m)! (l-m)! (l+m)!)`.
        let far = |m: usize, n: usize, l: usize| {
            let sign = if (n + m).is_multiple_of(2) { 1.0 } else { -1.0 };
            sign * (factorials[n + l] / root(n, m)) / root(l, m)
        };
        let orders = || 0..=MAX_ORDER;
        Self {
            places: orders()
                .map(|n| (0..=n).map(|m| index(n, m).map(|place| place - n * n)).collect())
                .collect(),
            swaps: swaps(HarmonicTables::get()),
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

/// Matrices of the exchange of y and z for each degree, as integrals over the sphere of the product
/// of one harmonic and another exchanged. All integrands are even in x, y and z: an octant is
/// enough.
fn swaps<E: Real>(tables: &HarmonicTables) -> Vec<[Swap<E>; 4]> {
    // Gauss-Legendre points in z and equidistant ones in azimuth integrate products of two
    // harmonics of the highest degree exactly.
    let azimuths = MAX_ORDER / 2 + 1;
    let mut samples = Vec::new();
    for [z, weight] in gauss_legendre(2 * azimuths).into_iter().filter(|[z, _]| *z > 0.0) {
        for j in 0..azimuths {
            let phi = 0.5 * PI * (j as f64 + 0.5) / azimuths as f64;
            let s = (1.0 - z * z).sqrt();
            let values = |x: [f64; 3]| {
                let mut out = vec![0.0; count(MAX_ORDER)];
                regular_at(tables, MAX_ORDER, x, &mut out);
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
