//! Sliding on a curve of quarter-ellipses with semi-axes `d`.
//!
//! With `x = d z` the curve is the unit circle. Slip against friction, of any strength `alpha`, is
//! `d (schur x + slip) = -alpha z`: for `alpha` from zero to infinity the friction goes from that
//! which sticks, outside its limit, to none, inside. In between `|z|` equals the normal impulse.
use super::{Pressed, solve_symmetric};
use nalgebra::{Matrix2, Vector2, Vector3};

/// Steps after which the bracket is taken as it is; a dozen are usual.
const STEPS: usize = 200;

pub(super) fn slide(problem: &Pressed, mu: &[f64; 4]) -> Vector3<f64> {
    let size = mu.iter().copied().fold(0.0, f64::max);
    let drive = size * problem.slip.norm();
    let mut low = 0.0;
    let mut high = drive * (1.0 + size * problem.pull.norm()) / problem.load;
    // Where both tangents answer alike this is the root.
    let square = size * size;
    let mut alpha = (drive - square * problem.pull.dot(&-problem.slip)) / problem.load
        - 0.5 * square * problem.schur.trace();
    let mut point = Vector2::zeros();
    for _ in 0..STEPS {
        if !(alpha > low && alpha < high) {
            alpha = if high > 16.0 * low && low > 0.0 {
                (low * high).sqrt()
            } else {
                0.5 * (low + high)
            };
        }
        let Some(at) = Point::new(problem, mu, alpha) else {
            return Vector3::new(problem.load, 0.0, 0.0);
        };
        point = at.friction;
        let step = at.excess / at.slope;
        let smallest = 2.0 * f64::EPSILON * alpha;
        if at.excess == 0.0 || step.abs() <= smallest || high - low <= smallest {
            break;
        }
        if at.excess < 0.0 {
            low = alpha;
        } else {
            high = alpha;
        }
        alpha -= step;
    }
    Vector3::new(problem.normal(&point), point.x, point.y)
}

/// The friction for one `alpha`.
struct Point {
    friction: Vector2<f64>,
    /// Normal impulse divided by `|z|`, less one: linear in `alpha` where both tangents answer
    /// alike.
    excess: f64,
    slope: f64,
}

impl Point {
    /// `None` if there is no friction in any direction that slips.
    fn new(problem: &Pressed, mu: &[f64; 4], alpha: f64) -> Option<Self> {
        let (semi, matrix, z) = quarter(problem, mu, alpha);
        let norm = z.norm();
        if norm <= 0.0 || norm.is_nan() {
            return None;
        }
        let friction = semi.component_mul(&z);
        let normal = problem.normal(&friction);
        let change = solve_symmetric(&matrix, &-z);
        let normal_change = problem.pull.dot(&semi.component_mul(&change));
        Some(Self {
            friction,
            excess: normal / norm - 1.0,
            slope: (normal_change - normal * z.dot(&change) / (norm * norm)) / norm,
        })
    }
}

/// The quarter in which the solution lies, as semi-axes, its matrix and the solution: there is
/// one, since the problem is a strictly convex one with a continuous gradient.
fn quarter(
    problem: &Pressed,
    mu: &[f64; 4],
    alpha: f64,
) -> (Vector2<f64>, Matrix2<f64>, Vector2<f64>) {
    let solve = |semi: Vector2<f64>| {
        let scale = Matrix2::from_diagonal(&semi);
        let matrix = scale * problem.schur * scale + Matrix2::from_diagonal_element(alpha);
        (semi, matrix, solve_symmetric(&matrix, &-semi.component_mul(&problem.slip)))
    };
    if mu[0] == mu[1] && mu[2] == mu[3] {
        return solve(Vector2::new(mu[0], mu[2]));
    }
    let mut best = None;
    let mut least = f64::INFINITY;
    for (sign, semi) in [
        (Vector2::new(1.0, 1.0), Vector2::new(mu[0], mu[2])),
        (Vector2::new(1.0, -1.0), Vector2::new(mu[0], mu[3])),
        (Vector2::new(-1.0, 1.0), Vector2::new(mu[1], mu[2])),
        (Vector2::new(-1.0, -1.0), Vector2::new(mu[1], mu[3])),
    ] {
        let solution = solve(semi);
        // How far it is outside of its quarter.
        let outside = -sign.component_mul(&semi.component_mul(&solution.2)).min().min(0.0);
        if outside < least {
            (best, least) = (Some(solution), outside);
        }
    }
    best.unwrap_or_else(|| solve(Vector2::new(mu[0], mu[2])))
}
