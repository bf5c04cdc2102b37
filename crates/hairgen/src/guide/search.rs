//! The quasi-Newton method of Broyden, Fletcher, Goldfarb and Shanno in the six components of an
//! end load.

use nalgebra::{Matrix6, Vector6};

/// Largest change of the load in a step, in its units, and relative to the load.
const LONGEST_STEP: [f64; 2] = [4.0, 0.25];
/// Shortest change of the load in a line search.
const SHORTEST: f64 = 1e-7;
/// Fraction of the decrease predicted by the slope that a step must bring (Armijo 1966).
const SUFFICIENT: f64 = 1e-4;

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

/// A function of an end load that has a minimum.
pub(super) trait Searched {
    /// What is kept of a point, here an equilibrium.
    type Kept;

    /// Value, gradient and what is to be kept of a point, from what was kept of a point nearby;
    /// `None` where there is no value.
    fn at(
        &mut self,
        point: &Vector6<f64>,
        near: &Self::Kept,
    ) -> Option<(f64, Vector6<f64>, Self::Kept)>;

    /// A guess at the inverse of the second derivatives at the point computed last.
    fn inverse_hessian(&self, kept: &Self::Kept) -> Option<Matrix6<f64>>;
}

/// Descends from `start` until the predicted decrease is less than `tolerance` times the value, or
/// `most` values are computed. Where there is no value the step is halved. `None` if there is none
/// at the start.
pub(super) fn minimize<F: Searched>(
    function: &mut F,
    start: &Vector6<f64>,
    kept: &F::Kept,
    tolerance: f64,
    most: usize,
) -> Option<Minimum<F::Kept>> {
    let mut point = *start;
    let (mut value, mut gradient, mut kept) = function.at(&point, kept)?;
    let mut inverse = function.inverse_hessian(&kept);
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
        if slope > -2.0 * tolerance * value.abs() {
            break;
        }
        // Without a guess the first step has no scale but that of the load.
        let longest = LONGEST_STEP[0] + LONGEST_STEP[1] * point.norm();
        let mut part = match inverse {
            Some(_) => (longest / step.norm()).min(1.0),
            None => step.norm().recip(),
        };
        let accepted = loop {
            if evaluations >= most || part * step.norm() < SHORTEST {
                break None;
            }
            evaluations += 1;
            let there = point + step * part;
            match function.at(&there, &kept) {
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

    /// Rosenbrock's valley in three planes, with its minimum at ones. No values here and there: the
    /// search goes around.
    struct Valley;

    impl Searched for Valley {
        type Kept = ();

        fn at(&mut self, x: &Vector6<f64>, (): &()) -> Option<(f64, Vector6<f64>, ())> {
            let (mut value, mut gradient) = (0.0, Vector6::zeros());
            for i in [0, 2, 4] {
                let (off, climb) = (1.0 - x[i], x[i + 1] - x[i] * x[i]);
                value += off * off + 10.0 * climb * climb;
                gradient[i] -= 2.0 * off + 40.0 * climb * x[i];
                gradient[i + 1] += 20.0 * climb;
            }
            (x[0] < 1.5).then_some((value, gradient, ()))
        }

        fn inverse_hessian(&self, (): &()) -> Option<Matrix6<f64>> {
            None
        }
    }

    #[test]
    fn a_curved_valley_is_followed_to_its_end() {
        let start = Vector6::new(-1.2, 1.0, 0.0, 0.0, 1.0, -1.0);
        let found = minimize(&mut Valley, &start, &(), 2.5e-8, 200).expect("a start");
        assert!(found.value < 1e-8 && found.evaluations < 100, "{}", found.evaluations);
        assert!((found.point - Vector6::repeat(1.0)).norm() < 1e-3, "{}", found.point);
        let few = minimize(&mut Valley, &start, &(), 2.5e-8, 7).expect("a start");
        assert_eq!(few.evaluations, 7);
        assert!(few.value < Valley.at(&start, &()).expect("a start").0);
        assert!(minimize(&mut Valley, &Vector6::repeat(2.0), &(), 2.5e-8, 7).is_none());
    }

    /// With the right second derivatives a quadratic function takes one step, from however far.
    #[test]
    fn a_guess_at_the_second_derivatives_sets_the_scale() {
        struct Bowl;
        impl Searched for Bowl {
            type Kept = ();
            fn at(&mut self, x: &Vector6<f64>, (): &()) -> Option<(f64, Vector6<f64>, ())> {
                Some((1e-4 * x.norm_squared() + 1.0, 2e-4 * x, ()))
            }
            fn inverse_hessian(&self, (): &()) -> Option<Matrix6<f64>> {
                Some(Matrix6::from_diagonal_element(5e3))
            }
        }
        let found = minimize(&mut Bowl, &Vector6::repeat(1.0), &(), 1e-12, 20).expect("a start");
        assert_eq!(found.evaluations, 2);
        assert!(found.point.norm() < 1e-12, "{}", found.point);
    }
}
