//! Linear equations by generalized minimal residuals (Saad and Schultz, 1986).

use crate::ElectrostaticsError;

/// Most iterations; each keeps a vector.
pub(super) const MOST_ITERATIONS: usize = 200;

/// Solution of `apply(x) = right` with the preconditioner `1/diagonal`, until the preconditioned
/// residual is below `tolerance` of that of zero, and its relative residual.
pub(super) fn solve(
    apply: impl Fn(&[f64]) -> Result<Vec<f64>, ElectrostaticsError>,
    diagonal: &[f64],
    right: &[f64],
    tolerance: f64,
) -> Result<(Vec<f64>, f64), ElectrostaticsError> {
    let over = |x: Vec<f64>| -> Vec<f64> { x.iter().zip(diagonal).map(|(x, d)| x / d).collect() };
    let start = over(right.to_vec());
    let size = norm(&start);
    let mut solution = vec![0.0; right.len()];
    if size == 0.0 {
        return Ok((solution, 0.0));
    }
    let mut basis = vec![scaled(&start, 1.0 / size)];
    // Columns of a triangular matrix, the rotations that made it so, and the rotated right-hand
    // side.
    let (mut columns, mut turns, mut rest) = (Vec::new(), Vec::<[f64; 2]>::new(), vec![size]);
    for k in 0..MOST_ITERATIONS {
        // Arnoldi step by modified Gram-Schmidt.
        let mut next = over(apply(&basis[k])?);
        let mut column = Vec::with_capacity(k + 2);
        for vector in &basis {
            let share = dot(vector, &next);
            next.iter_mut().zip(vector).for_each(|(x, v)| *x -= share * v);
            column.push(share);
        }
        // Givens rotations keep the Hessenberg matrix triangular, and the last entry of the
        // right-hand side is the residual.
        let length = norm(&next);
        for (i, [c, s]) in turns.iter().enumerate() {
            let [a, b] = [column[i], column[i + 1]];
            [column[i], column[i + 1]] = [c * a + s * b, c * b - s * a];
        }
        let radius = column[k].hypot(length);
        let turn = if radius > 0.0 { [column[k] / radius, length / radius] } else { [1.0, 0.0] };
        column[k] = radius;
        columns.push(column);
        turns.push(turn);
        rest.push(-turn[1] * rest[k]);
        rest[k] *= turn[0];
        if rest[k + 1].abs() <= tolerance * size || length == 0.0 {
            break;
        }
        basis.push(scaled(&next, 1.0 / length));
    }
    // Back substitution.
    let count = columns.len();
    let mut shares = rest[..count].to_vec();
    for k in (0..count).rev() {
        if columns[k][k] == 0.0 {
            continue;
        }
        shares[k] /= columns[k][k];
        for i in 0..k {
            shares[i] -= columns[k][i] * shares[k];
        }
    }
    for (share, vector) in shares.iter().zip(&basis) {
        solution.iter_mut().zip(vector).for_each(|(x, v)| *x += share * v);
    }
    Ok((solution, rest[count].abs() / size))
}

/// Scalar product.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Euclidean norm.
fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Product `factor a`.
fn scaled(a: &[f64], factor: f64) -> Vec<f64> {
    a.iter().map(|a| factor * a).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix that is not symmetric is solved within as many steps as it has rows.
    #[test]
    fn equations_are_solved() {
        let n = 12;
        let entry = |i: usize, j: usize| {
            let sign = if (i + 2 * j).is_multiple_of(3) { -0.1 } else { 0.2 };
            if i == j { 2.0 + i as f64 } else { sign }
        };
        let apply =
            |x: &[f64]| Ok((0..n).map(|i| (0..n).map(|j| entry(i, j) * x[j]).sum()).collect());
        let exact: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let right = apply(&exact).expect("defined");
        let diagonal: Vec<f64> = (0..n).map(|i| entry(i, i)).collect();
        let (found, residual) = solve(apply, &diagonal, &right, 1e-13).expect("defined");
        assert!(residual < 1e-13, "{residual}");
        for (found, exact) in found.iter().zip(&exact) {
            assert!((found - exact).abs() < 1e-12, "{found}, not {exact}");
        }
        let (zero, _) = solve(apply, &diagonal, &vec![0.0; n], 1e-13).expect("defined");
        assert!(zero.iter().all(|x| *x == 0.0));
    }
}
