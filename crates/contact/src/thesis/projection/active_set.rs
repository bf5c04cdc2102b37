use nalgebra::{Cholesky, DMatrix, DVector};

/// Below this share of a diagonal entry what is left of it after elimination is rounding.
const DEPENDENT: f64 = 1e-11;

/// A slope below this share of the sizes that it is the sum of is rounding.
const SLOPE_ROUNDING: f64 = 1e-13;

/// `argmin 1/2 x^T G x + c^T x` over `x >= 0` for a symmetric positive semidefinite `G`, by an
/// active set in the manner of Lawson and Hanson: variables enter by the steepest scaled descent, a
/// variable that depends on those that are in pushes one of them out. Exact to rounding.
///
/// `None` if the objective has no lower bound or the set does not settle. Costs a factorization of
/// the variables that are in for each that enters.
pub(super) fn minimize(g: &DMatrix<f64>, c: &DVector<f64>) -> Option<DVector<f64>> {
    let n = c.len();
    let mut x = DVector::zeros(n);
    let mut inside: Vec<usize> = Vec::new();
    let scale: Vec<f64> = (0..n).map(|i| g[(i, i)].max(0.0).sqrt()).collect();
    let scaled = |i: usize, value: f64| if scale[i] > 0.0 { value / scale[i] } else { value };
    let sizes = g.abs();
    for _ in 0..10 * n + 20 {
        let slope = g * &x + c;
        let rounding = (&sizes * x.abs() + c.abs()) * SLOPE_ROUNDING;
        let entering = (0..n)
            .filter(|i| !inside.contains(i) && slope[*i] < -rounding[*i])
            .map(|i| (i, scaled(i, slope[i])))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((entering, _)) = entering else { return Some(x) };
        make_room(g, &mut x, &mut inside, entering)?;
        inside.push(entering);
        settle(g, c, &mut x, &mut inside)?;
    }
    None
}

/// Where `entering` depends on the variables inside, moves along the null direction until one of
/// them is zero, and takes that out.
fn make_room(
    g: &DMatrix<f64>,
    x: &mut DVector<f64>,
    inside: &mut Vec<usize>,
    entering: usize,
) -> Option<()> {
    let column = DVector::from_iterator(inside.len(), inside.iter().map(|&i| g[(i, entering)]));
    let others = solve(g, inside, &column)?;
    if g[(entering, entering)] - column.dot(&others) > DEPENDENT * g[(entering, entering)] {
        return Some(());
    }
    let (leaving, step) = others
        .iter()
        .enumerate()
        .filter(|(_, z)| **z > 0.0)
        .map(|(k, z)| (k, x[inside[k]] / z))
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    for (k, &i) in inside.iter().enumerate() {
        x[i] -= step * others[k];
    }
    x[entering] += step;
    x[inside[leaving]] = 0.0;
    inside.remove(leaving);
    Some(())
}

/// Goes to the minimum over the variables inside, letting go of those that would become negative.
fn settle(
    g: &DMatrix<f64>,
    c: &DVector<f64>,
    x: &mut DVector<f64>,
    inside: &mut Vec<usize>,
) -> Option<()> {
    while !inside.is_empty() {
        let right = DVector::from_iterator(inside.len(), inside.iter().map(|&i| -c[i]));
        let goal = solve(g, inside, &right)?;
        let blocking = inside
            .iter()
            .enumerate()
            .filter(|(k, _)| goal[*k] < 0.0)
            .map(|(k, &i)| (k, x[i] / (x[i] - goal[k])))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let step = blocking.map_or(1.0, |(_, step)| step);
        for (k, &i) in inside.iter().enumerate() {
            x[i] = if step < 1.0 { x[i] + step * (goal[k] - x[i]) } else { goal[k] };
        }
        let Some((leaving, _)) = blocking else { return Some(()) };
        x[inside[leaving]] = 0.0;
        inside.remove(leaving);
    }
    Some(())
}

fn solve(g: &DMatrix<f64>, inside: &[usize], right: &DVector<f64>) -> Option<DVector<f64>> {
    if inside.is_empty() {
        return Some(DVector::zeros(0));
    }
    Some(Cholesky::new(g.select_rows(inside).select_columns(inside))?.solve(right))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thesis::projection::program;
    use proptest::prelude::*;

    proptest! {
        /// More contacts than degrees of freedom, so that there are many minima. (The contacts push
        /// to one side: the minima of bodies that are squeezed are unbounded, which an interior
        /// point does not like.)
        #[test]
        fn meets_the_interior_point(
            rank in 1..6_usize,
            n in 1..10_usize,
            numbers in prop::collection::vec(-1.0..1.0_f64, 60),
        ) {
            let mut rows = DMatrix::from_column_slice(n, rank, &numbers[..n * rank]);
            rows.column_mut(0).apply(|x| *x = 0.3 + x.abs());
            let before = DVector::from_column_slice(&numbers[54..54 + rank]);
            let (g, c) = (&rows * rows.transpose(), &rows * before);
            let fast = minimize(&g, &c).expect("bounded below, as c is in the range of G");
            prop_assert!(fast.min() >= 0.0);
            prop_assert!((&g * &fast + &c).min() > -1e-11);
            prop_assert!(fast.dot(&(&g * &fast + &c)).abs() < 1e-11 * (1.0 + fast.amax()));
            let slow = program::solve(&g, &c, &-DMatrix::identity(n, n), &DVector::zeros(n));
            let slow = slow.expect("bounded");
            let cost = |x: &DVector<f64>| 0.5 * x.dot(&(&g * x)) + c.dot(x);
            prop_assert!((cost(&fast) - cost(&slow)).abs() < 1e-6);
        }
    }

    #[test]
    fn an_unbounded_program_has_no_answer() {
        let g = DMatrix::from_row_slice(2, 2, &[1.0, -1.0, -1.0, 1.0]);
        assert_eq!(minimize(&g, &DVector::from_vec(vec![-1.0, -1.0])), None);
    }
}
