//! Products of the constant matrices that move expansions and the coefficients of some registers.

use super::shift::TranslationKind;
use super::translation_tables::Matrix;
use pulp::Simd;
use rapunzel_lanes::Real;

/// Coefficient of the expansions in `C` registers side by side, which share the constants. Bare
/// registers and not lanes: the space for them is cut out of one array of numbers.
pub(super) type TurnBlock<S, E, const C: usize> = [<E as Real>::Register<S>; C];

/// Product `out = matrix x`, by blocks of eight rows.
#[inline(always)]
pub(super) fn product<S: Simd, E: Real, const C: usize>(
    simd: S,
    matrix: &Matrix<E, 8>,
    x: &[TurnBlock<S, E, C>],
    out: &mut [TurnBlock<S, E, C>],
) {
    for (block, out) in out.chunks_mut(8).enumerate() {
        let columns = matrix.block(block);
        match out.len() {
            1 => rows::<S, E, 1, C>(simd, columns, x, out),
            2 => rows::<S, E, 2, C>(simd, columns, x, out),
            3 => rows::<S, E, 3, C>(simd, columns, x, out),
            4 => rows::<S, E, 4, C>(simd, columns, x, out),
            5 => rows::<S, E, 5, C>(simd, columns, x, out),
            6 => rows::<S, E, 6, C>(simd, columns, x, out),
            7 => rows::<S, E, 7, C>(simd, columns, x, out),
            _ => rows::<S, E, 8, C>(simd, columns, x, out),
        }
    }
}

/// Product of `R` rows of a matrix and `x`.
#[inline(always)]
fn rows<S: Simd, E: Real, const R: usize, const C: usize>(
    simd: S,
    columns: &[[E; 8]],
    x: &[TurnBlock<S, E, C>],
    out: &mut [TurnBlock<S, E, C>],
) {
    let mut sums = [[E::splat(simd, E::from_f64(0.0)); C]; R];
    for (column, x) in columns.iter().zip(x) {
        for r in 0..R {
            let entry = E::splat(simd, column[r]);
            for c in 0..C {
                sums[r][c] = E::mul_add(simd, entry, x[c], sums[r][c]);
            }
        }
    }
    // One by one: a copy of all would keep the sums in memory.
    for (out, sum) in out.iter_mut().zip(sums) {
        *out = sum;
    }
}

/// Product of `R` rows of the matrix that takes a multipole along z to a local expansion, and the
/// cosines and sines `x`.
#[inline(always)]
pub(super) fn far<S: Simd, E: Real, const R: usize, const C: usize>(
    simd: S,
    columns: &[[E; 4]],
    x: &[[TurnBlock<S, E, C>; 2]],
    out: &mut [[TurnBlock<S, E, C>; 2]],
) {
    let mut sums = [[[E::splat(simd, E::from_f64(0.0)); C]; 2]; R];
    for (column, x) in columns.iter().zip(x) {
        for r in 0..R {
            let entry = E::splat(simd, column[r]);
            for part in 0..2 {
                for c in 0..C {
                    sums[r][part][c] = E::mul_add(simd, entry, x[part][c], sums[r][part][c]);
                }
            }
        }
    }
    // One by one: a copy of all would keep the sums in memory.
    for (out, sum) in out.iter_mut().zip(sums) {
        *out = sum;
    }
}

/// Product of the triangular `matrix` that shifts a multipole along z, or of its transpose, which
/// shifts a local expansion, and the cosines and sines `x`.
#[inline(always)]
pub(super) fn triangle<S: Simd, E: Real, const C: usize>(
    simd: S,
    matrix: &[Vec<E>],
    kind: TranslationKind,
    steps: &[TurnBlock<S, E, C>],
    x: &[[TurnBlock<S, E, C>; 2]],
    y: &mut [[TurnBlock<S, E, C>; 2]],
) {
    for (n, y) in y.iter_mut().enumerate() {
        *y = [[E::splat(simd, E::from_f64(0.0)); C]; 2];
        let range = match kind {
            TranslationKind::Multipole => 0..x.len().min(n + 1),
            _ => n.min(x.len())..x.len(),
        };
        for l in range {
            let entry =
                if kind == TranslationKind::Multipole { matrix[n][l] } else { matrix[l][n] };
            for c in 0..C {
                let factor = E::mul(simd, steps[n.abs_diff(l)][c], E::splat(simd, entry));
                for part in 0..2 {
                    y[part][c] = E::mul_add(simd, factor, x[l][part][c], y[part][c]);
                }
            }
        }
    }
}
