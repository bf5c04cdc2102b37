use nalgebra::{Cholesky, DMatrix, DVector};

/// Below this share of a diagonal entry what is left of it after elimination is rounding.
const DEPENDENT: f64 = 1e-11;

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
    let steepest = (0..n).map(|i| scaled(i, c[i])).fold(0.0, f64::min);
    let tolerance = -1e-13 * steepest;
    for _ in 0..10 * n + 20 {
        let slope = g * &x + c;
        let entering = (0..n)
            .filter(|i| !inside.contains(i))
            .map(|i| (i, scaled(i, slope[i])))
            .filter(|(_, slope)| *slope < -tolerance)
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
