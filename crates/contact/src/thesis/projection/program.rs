//! The only door to clarabel.

use crate::ContactError;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};
use nalgebra::{DMatrix, DVector};

/// `argmin 1/2 x^T h x + g^T x` such that `a x <= b`, for a positive semidefinite `h`, by
/// clarabel's interior point method. Zero should be feasible. Numbers of any size: the program is
/// brought to units of one before.
///
/// # Errors
/// [`ContactError::Program`] where it has no solution or none is found to 1e-6 (1e-10 is usual).
pub(super) fn solve(
    h: &DMatrix<f64>,
    g: &DVector<f64>,
    a: &DMatrix<f64>,
    b: &DVector<f64>,
) -> Result<DVector<f64>, ContactError> {
    let (variables, rows) = (g.len(), b.len());
    let norms: Vec<f64> = (0..rows).map(|i| a.row(i).norm()).collect();
    let row_scale = |i: usize| if norms[i] > 0.0 { 1.0 / norms[i] } else { 1.0 };
    let reach = (0..rows).map(|i| (b[i] * row_scale(i)).abs()).fold(0.0, f64::max);
    let reach = if reach > 0.0 { reach } else { 1.0 };
    let size = (h.amax() * reach).max(g.amax());
    let size = if size > 0.0 { size } else { 1.0 };
    let mut objective = h * (reach / size);
    objective.fill_lower_triangle(0.0, 1);
    let linear: Vec<f64> = g.iter().map(|x| x / size).collect();
    let mut rows_scaled = a.clone();
    for i in 0..rows {
        rows_scaled.row_mut(i).scale_mut(row_scale(i));
    }
    let bounds: Vec<f64> = (0..rows).map(|i| b[i] * row_scale(i) / reach).collect();
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-10,
        tol_gap_rel: 1e-10,
        tol_feas: 1e-10,
        ..DefaultSettings::default()
    };
    let failed = |why: String| ContactError::Program { variables, constraints: rows, why };
    let mut solver = DefaultSolver::new(
        &sparse(&objective),
        &linear,
        &sparse(&rows_scaled),
        &bounds,
        &[NonnegativeConeT(rows)],
        settings,
    )
    .map_err(|error| failed(error.to_string()))?;
    solver.solve();
    // Degenerate programs stall before the tolerances are met; then the residuals, in units of one,
    // decide.
    let solution = &solver.solution;
    let gap = (solution.obj_val - solution.obj_val_dual).abs() / (1.0 + solution.obj_val.abs());
    let close = solution.r_prim.max(solution.r_dual).max(gap) < 1e-6;
    use SolverStatus::{AlmostSolved, InsufficientProgress, MaxIterations, Solved};
    match solution.status {
        Solved => {}
        AlmostSolved | InsufficientProgress | MaxIterations if close => {}
        other => return Err(failed(other.to_string())),
    }
    Ok(DVector::from_iterator(variables, solution.x.iter().map(|x| x * reach)))
}

fn sparse(matrix: &DMatrix<f64>) -> CscMatrix<f64> {
    let mut column_starts = vec![0];
    let (mut rows, mut values) = (Vec::new(), Vec::new());
    for column in matrix.column_iter() {
        for (i, &value) in column.iter().enumerate().filter(|(_, value)| **value != 0.0) {
            rows.push(i);
            values.push(value);
        }
        column_starts.push(rows.len());
    }
    CscMatrix::new(matrix.nrows(), matrix.ncols(), column_starts, rows, values)
}
