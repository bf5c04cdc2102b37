//! The quasi-Newton method of Broyden, Fletcher, Goldfarb and Shanno in the six components of an
//! end load.

use nalgebra::{Matrix6, Vector6};

/// Largest change of the load in a step, in its units.
const LONGEST_STEP: f64 = 4.0;
/// Shortest change of the load in a line search.
const SHORTEST: f64 = 1e-7;
/// Fraction of the decrease predicted by the slope that a step must bring (Armijo 1966).
const SUFFICIENT: f64 = 1e-4;
/// Slope along a step, relative to the value, at which the minimum is reached: twice the decrease
/// that is left.
const SETTLED: f64 = 5e-8;

/// The end of a search.
pub(super) struct Minimum<T> {
    /// The point, here an end load.
    pub(super) point: Vector6<f64>,
    pub(super) value: f64,
    /// What the function keeps of the point, here the shape.
    pub(super) kept: T,
    /// Number of values that were computed, also failed ones.
    pub(super) evaluations: usize,
}

/// Descends from `start` until the predicted decrease is a small part of the value, or `most`
/// values are computed. `function` gives value, gradient and what is to be kept of a point, from
/// what was kept of the point before; where it gives none the step is halved. `None` if there is no
/// value at the start.
pub(super) fn minimize<T>(
    start: &Vector6<f64>,
    kept: &T,
    most: usize,
    mut function: impl FnMut(&Vector6<f64>, &T) -> Option<(f64, Vector6<f64>, T)>,
) -> Option<Minimum<T>> {
    let mut point = *start;
    let (mut value, mut gradient, mut kept) = function(&point, kept)?;
    let mut inverse: Option<Matrix6<f64>> = None;
    let mut evaluations = 1;
    while evaluations < most {
        let mut step = match &inverse {
            Some(inverse) => -(inverse * gradient),
            None => -gradient,
        };
        let mut slope = step.dot(&gradient);
        if slope >= 0.0 {
            (inverse, step, slope) = (None, -gradient, -gradient.norm_squared());
        }
        if slope > -SETTLED * value.abs() {
            break;
        }
        // The first step has no scale but that of the load.
        let mut part = match inverse {
            Some(_) => (LONGEST_STEP / step.norm()).min(1.0),
            None => step.norm().recip(),
        };
        let accepted = loop {
            if evaluations >= most || part * step.norm() < SHORTEST {
                break None;
            }
            evaluations += 1;
            let there = point + step * part;
            match function(&there, &kept) {
                Some(next) if next.0 <= value + SUFFICIENT * part * slope => {
                    break Some((there, next));
                }
                // The lowest point of the parabola through value, slope and the trial.
                Some((trial, ..)) => {
                    let bend = (trial - value) / part - slope;
                    part *= (-0.5 * slope / bend).clamp(0.1, 0.5);
                }
                None => part *= 0.5,
            }
        };
        let Some((there, (lower, next, shape))) = accepted else {
            if inverse.take().is_none() {
                break;
            }
            continue;
        };
        let (moved, turned) = (there - point, next - gradient);
        update(&mut inverse, &moved, &turned);
        (point, value, gradient, kept) = (there, lower, next, shape);
    }
    Some(Minimum { point, value, kept, evaluations })
}

/// Takes the change `turned` of the gradient along the step `moved` into the inverse Hessian; left
/// out where the curvature along the step is not positive.
fn update(inverse: &mut Option<Matrix6<f64>>, moved: &Vector6<f64>, turned: &Vector6<f64>) {
    let along = moved.dot(turned);
    if along <= 1e-10 * moved.norm() * turned.norm() {
        return;
    }
    let unit = Matrix6::identity();
    let before = inverse.unwrap_or_else(|| unit * (along / turned.norm_squared()));
    let left = unit - moved * turned.transpose() / along;
    *inverse = Some(left * before * left.transpose() + moved * moved.transpose() / along);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley in three planes, and its minimum at ones.
    #[test]
    fn a_curved_valley_is_followed_to_its_end() {
        let function = |x: &Vector6<f64>, (): &()| {
            let (mut value, mut gradient) = (0.0, Vector6::zeros());
            for i in [0, 2, 4] {
                let (off, climb) = (1.0 - x[i], x[i + 1] - x[i] * x[i]);
                value += off * off + 10.0 * climb * climb;
                gradient[i] -= 2.0 * off + 40.0 * climb * x[i];
                gradient[i + 1] += 20.0 * climb;
            }
            // No values here and there: the search goes around.
            (x[0] < 1.5).then_some((value, gradient, ()))
        };
        let start = Vector6::new(-1.2, 1.0, 0.0, 0.0, 1.0, -1.0);
        let found = minimize(&start, &(), 200, function).expect("a start");
        assert!(found.value < 1e-8 && found.evaluations < 100, "{}", found.evaluations);
        assert!((found.point - Vector6::repeat(1.0)).norm() < 1e-3, "{}", found.point);
        let few = minimize(&start, &(), 7, function).expect("a start");
        assert_eq!(few.evaluations, 7);
        assert!(few.value < function(&start, &()).expect("a start").0);
        assert!(minimize(&Vector6::repeat(2.0), &(), 7, function).is_none());
    }
}
