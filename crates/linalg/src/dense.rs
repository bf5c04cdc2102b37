//! Dense matrices. With `sparse` the only file that speaks to faer.

use crate::LinalgError;
use faer::linalg::solvers::{SelfAdjointEigen, Solve};
use faer::{Mat, MatRef, Side};
use nalgebra::{Complex, DMatrix};

/// A stiffness with a smaller pivot, in parts of the largest, has a motion that costs no energy.
const STIFF: f64 = 1e-12;

/// Free vibrations without damping: `q` is a shape times `cos(omega t)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Modes {
    /// Squares of the angular frequencies, rising: `omega^2`, 1/s^2 where stiffness and mass are
    /// in SI units; negative for a motion that grows with the rate `sqrt(-omega^2)`.
    pub squares: Vec<f64>,
    /// A column for each, of modal mass 1: `x^T M x = 1`, and 0 between two of them.
    pub shapes: DMatrix<f64>,
}

impl Modes {
    /// Angular frequencies, 1/s, rising; zero where a motion grows.
    #[must_use]
    pub fn angular_frequencies(&self) -> Vec<f64> {
        self.squares.iter().map(|square| square.max(0.0).sqrt()).collect()
    }
}

/// The `count` modes of lowest `omega^2` of `M q'' + K q = 0`, `K x = omega^2 M x`; all of them if
/// there are fewer. Of both symmetric matrices the lower triangle is read.
///
/// For a positive definite `stiffness` the largest eigenvalues of `K^-1 M` are taken, so that low
/// frequencies are exact to rounding however high the highest is; of an `omega^2` that is `1e16`
/// times the lowest, only that it is so large is known. Otherwise an error of `1e-16` of the
/// highest `omega^2` remains in each. Cost: about `9 n^3` operations, memory `5 n^2`.
///
/// # Errors
/// [`LinalgError::Size`] and [`LinalgError::NotFinite`] for matrices that are not square, of
/// one size and finite, [`LinalgError::Mass`] for a mass that is not positive definite (it may
/// be semidefinite if the stiffness is definite), [`LinalgError::NotConverged`].
///
/// ```
/// use nalgebra::dmatrix;
/// use rapunzel_linalg::modes;
///
/// // Three equal masses between two walls, on four equal springs.
/// let k = dmatrix![2.0, -1.0, 0.0; -1.0, 2.0, -1.0; 0.0, -1.0, 2.0];
/// let lowest = modes(&k, &dmatrix![1.0, 0.0, 0.0; 0.0, 1.0, 0.0; 0.0, 0.0, 1.0], 1)?;
/// assert!((lowest.squares[0] - (2.0 - 2.0_f64.sqrt())).abs() < 1e-15);
/// # Ok::<(), rapunzel_linalg::LinalgError>(())
/// ```
pub fn modes(
    stiffness: &DMatrix<f64>,
    mass: &DMatrix<f64>,
    count: usize,
) -> Result<Modes, LinalgError> {
    let (k, m) = pair(stiffness, mass)?;
    let count = count.min(k.nrows());
    if count == 0 {
        return Ok(Modes { squares: Vec::new(), shapes: DMatrix::zeros(k.nrows(), 0) });
    }
    let (squares, mut shapes) = if let Some(Reduced { factor, eigen }) = reduce(k, m, STIFF)? {
        let inverses: Vec<f64> = eigen.S().column_vector().iter().rev().copied().collect();
        let rounding = inverses.first().map_or(0.0, |largest| f64::EPSILON * largest);
        if inverses.last().is_some_and(|least| *least < -(k.nrows() as f64) * rounding) {
            return Err(LinalgError::Mass);
        }
        let squares = inverses[..count].iter().map(|x| 1.0 / x.max(rounding)).collect();
        (squares, undo(&factor, eigen.U().reverse_cols().subcols(0, count)))
    } else {
        let Reduced { factor, eigen } = reduce(m, k, 0.0)?.ok_or(LinalgError::Mass)?;
        let squares: Vec<f64> = eigen.S().column_vector().iter().take(count).copied().collect();
        (squares, undo(&factor, eigen.U().subcols(0, count)))
    };
    for mut shape in shapes.column_iter_mut() {
        let modal_mass = shape.dot(&(mass * &shape));
        if modal_mass > 0.0 {
            shape /= modal_mass.sqrt();
        }
    }
    if squares.iter().chain(&shapes).all(|x| x.is_finite()) {
        Ok(Modes { squares, shapes })
    } else {
        Err(LinalgError::NotConverged)
    }
}

/// All modes of a `stiffness` in coordinates of mass 1: its eigenvalues, rising, and orthonormal
/// eigenvectors. The lower triangle is read. An error of `1e-16` of the largest remains in each.
/// Cost: about `9 n^3` operations, memory `4 n^2`.
///
/// # Errors
/// As [`modes`], but for what concerns the mass.
pub fn eigen(stiffness: &DMatrix<f64>) -> Result<Modes, LinalgError> {
    let stiffness = square("stiffness", stiffness, stiffness.nrows())?;
    // The library counts down from the number of rows.
    if stiffness.nrows() == 0 {
        return Ok(Modes { squares: Vec::new(), shapes: DMatrix::zeros(0, 0) });
    }
    let eigen = stiffness.self_adjoint_eigen(Side::Lower).map_err(|_| LinalgError::NotConverged)?;
    let squares = eigen.S().column_vector().iter().copied().collect();
    Ok(Modes { squares, shapes: owned(eigen.U()) })
}

/// The smallest eigenvalue of a symmetric `matrix`, of which the lower triangle is read; infinite
/// without rows. Its error is `1e-16` of the largest. Cost: about `4/3 n^3` operations.
///
/// # Errors
/// As [`eigen`].
pub fn smallest_eigenvalue(matrix: &DMatrix<f64>) -> Result<f64, LinalgError> {
    let matrix = square("matrix", matrix, matrix.nrows())?;
    if matrix.nrows() == 0 {
        return Ok(f64::INFINITY);
    }
    let values =
        matrix.self_adjoint_eigenvalues(Side::Lower).map_err(|_| LinalgError::NotConverged)?;
    Ok(values.first().copied().unwrap_or(f64::INFINITY))
}

/// The rates `s` of the motions `q = Re(exp(s t) x)` of `M q'' + K q = 0`, one of each pair `s`,
/// `-s`, smallest in size first: real part growth, not negative, imaginary part angular frequency,
/// 1/s. The stiffness need not be symmetric; a growth beside a frequency is flutter.
///
/// As in [`modes`] the inverse gives the low ones exactly, unless the stiffness is singular.
/// Cost: about `12 n^3` operations, not all of which are fast, memory `4 n^2`.
///
/// # Errors
/// As [`modes`], but [`LinalgError::Mass`] for every mass that is singular.
pub fn characteristic_exponents(
    stiffness: &DMatrix<f64>,
    mass: &DMatrix<f64>,
) -> Result<Vec<Complex<f64>>, LinalgError> {
    let (k, m) = pair(stiffness, mass)?;
    if k.nrows() == 0 {
        return Ok(Vec::new());
    }
    let mut matrix = k.partial_piv_lu().solve(m);
    let inverse = matrix.is_all_finite();
    if !inverse {
        matrix = m.llt(Side::Lower).map_err(|_| LinalgError::Mass)?.solve(k);
    }
    let squares = matrix.eigenvalues().map_err(|_| LinalgError::NotConverged)?;
    let rate = |x: &Complex<f64>| {
        let s = if inverse { -x.inv() } else { -x }.sqrt();
        Complex::new(s.re.abs(), s.im.abs())
    };
    let mut rates: Vec<_> = squares.iter().map(rate).collect();
    rates.sort_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr()));
    if rates.iter().all(|s| s.is_finite()) {
        Ok(rates)
    } else if inverse {
        // What follows at once has no rate.
        Err(LinalgError::Mass)
    } else {
        Err(LinalgError::NotConverged)
    }
}

/// `L` of `a = L L^T`, and the eigenvalues and vectors of `L^-1 b L^-T`.
struct Reduced {
    factor: Mat<f64>,
    eigen: SelfAdjointEigen<f64>,
}

/// Takes `a` into `b`, for an `a` whose pivots are positive and all larger than the part `pivot` of
/// the largest.
fn reduce(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    pivot: f64,
) -> Result<Option<Reduced>, LinalgError> {
    let Ok(factor) = a.llt(Side::Lower) else { return Ok(None) };
    let roots = factor.L().diagonal().column_vector();
    let (least, largest) =
        roots.iter().fold((f64::INFINITY, 0.0_f64), |(l, g), x| (l.min(*x), g.max(*x)));
    if least <= pivot.sqrt() * largest {
        return Ok(None);
    }
    let symmetric = |i, j| if i < j { b[(j, i)] } else { b[(i, j)] };
    let mut half = Mat::from_fn(b.nrows(), b.ncols(), symmetric);
    factor.L().solve_lower_triangular_in_place(&mut half);
    let mut both = half.transpose().to_owned();
    factor.L().solve_lower_triangular_in_place(&mut both);
    if !both.is_all_finite() {
        return Ok(None);
    }
    let eigen = both.self_adjoint_eigen(Side::Lower).map_err(|_| LinalgError::NotConverged)?;
    Ok(Some(Reduced { factor: factor.L().to_owned(), eigen }))
}

/// Vectors `L^-T y`.
fn undo(factor: &Mat<f64>, vectors: MatRef<'_, f64>) -> DMatrix<f64> {
    let mut shapes = vectors.to_owned();
    factor.transpose().solve_upper_triangular_in_place(&mut shapes);
    owned(shapes.as_ref())
}

/// Stiffness and mass of one size.
fn pair<'a>(
    stiffness: &'a DMatrix<f64>,
    mass: &'a DMatrix<f64>,
) -> Result<(MatRef<'a, f64>, MatRef<'a, f64>), LinalgError> {
    let size = stiffness.nrows();
    Ok((square("stiffness", stiffness, size)?, square("mass", mass, size)?))
}

/// A view of a square matrix of finite numbers.
fn square<'a>(
    what: &'static str,
    matrix: &'a DMatrix<f64>,
    expected: usize,
) -> Result<MatRef<'a, f64>, LinalgError> {
    let (rows, columns) = matrix.shape();
    if [rows, columns] != [expected; 2] {
        return Err(LinalgError::Size { what, rows, columns, expected });
    }
    let view = MatRef::from_column_major_slice(matrix.as_slice(), rows, columns);
    if view.is_all_finite() { Ok(view) } else { Err(LinalgError::NotFinite { what }) }
}

/// A copy for others.
fn owned(matrix: MatRef<'_, f64>) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)])
}
