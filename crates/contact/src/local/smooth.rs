//! Sliding on a curve of quarter-ellipses with semi-axes `d`.
//!
//! With `x = d z` the curve is the unit circle. Slip against friction, of any strength `alpha`, is
//! `d (schur x + slip) = -alpha z`: for `alpha` from zero to infinity the friction goes from that
//! which sticks, outside its limit, to none, inside. In between `|z|` equals the normal impulse.
use super::pressed_contact::PressedContact;
use nalgebra::{Matrix2, Vector2, Vector3};

/// Steps after which the bracket is taken as it is; a dozen are usual.
const MAX_STEPS: usize = 200;

/// Impulse of a contact that slides, N s, from the cone's tip, with the coefficients of friction
/// `mu` along `t1`, `-t1`, `t2`, `-t2`: the root in `alpha` of `r_n = |z|`, by Newton's method in a
/// bracket.
pub(super) fn slide(problem: &PressedContact, mu: &[f64; 4]) -> Vector3<f64> {
    let first = CurveQuarter::new(problem, [1.0, 1.0], [mu[0], mu[2]]);
    let quarters = if mu[0] == mu[1] && mu[2] == mu[3] {
        &[first][..]
    } else {
        &[
            first,
            CurveQuarter::new(problem, [1.0, -1.0], [mu[0], mu[3]]),
            CurveQuarter::new(problem, [-1.0, 1.0], [mu[1], mu[2]]),
            CurveQuarter::new(problem, [-1.0, -1.0], [mu[1], mu[3]]),
        ]
    };
    let size = mu.iter().copied().fold(0.0, f64::max);
    let drive = size * problem.slip.norm();
    // Bracket of the root and a first guess.
    let mut low = 0.0;
    let mut high = drive * (1.0 + size * problem.pull.norm()) / problem.load;
    // Where both tangents answer alike this is the root.
    let square = size * size;
    let mut alpha = (drive + square * problem.pull.dot(&problem.slip)) / problem.load
        - 0.5 * square * problem.schur.trace();
    let mut point = Vector2::zeros();
    for _ in 0..MAX_STEPS {
        if !(alpha > low && alpha < high) {
            alpha = if high > 16.0 * low && low > 0.0 {
                (low * high).sqrt()
            } else {
                0.5 * (low + high)
            };
        }
        let quarter = containing(problem, quarters, alpha);
        let z = quarter.solution(alpha);
        point = quarter.friction(&z);
        let norm = z.norm();
        if norm <= 0.0 || norm.is_nan() {
            // Nothing resists any slip.
            return Vector3::new(problem.load, 0.0, 0.0);
        }
        // Normal impulse divided by |z|, less one: linear in alpha where both tangents answer
        // alike.
        let normal = problem.load + quarter.pull.dot(&z);
        let excess = normal / norm - 1.0;
        let change = -z.component_div(&quarter.eigenvalues.add_scalar(alpha));
        let slope = (quarter.pull.dot(&change) - normal * z.dot(&change) / (norm * norm)) / norm;
        let step = excess / slope;
        let smallest = 2.0 * f64::EPSILON * alpha;
        if excess == 0.0 || step.abs() <= smallest || high - low <= smallest {
            break;
        }
        if excess < 0.0 {
            low = alpha;
        } else {
            high = alpha;
        }
        alpha -= step;
    }
    Vector3::new(problem.normal_impulse(&point), point.x, point.y)
}

/// The problem in one quarter, in the eigenvectors of the answer to `z`: exact for small
/// eigenvalues also.
#[derive(Clone, Copy)]
struct CurveQuarter {
    /// Signs of the friction's components.
    sign: [f64; 2],
    /// Semi-axes `d` of the ellipse.
    semi: Vector2<f64>,
    /// Eigenvectors, in columns.
    axes: Matrix2<f64>,
    /// Eigenvalues, 1/kg.
    eigenvalues: Vector2<f64>,
    /// Slip without friction, scaled by `d`, along the eigenvectors, m/s.
    slip: Vector2<f64>,
    /// Normal impulse per `z`, along the eigenvectors.
    pull: Vector2<f64>,
}

impl CurveQuarter {
    /// The problem in the quarter with these signs and semi-axes.
    fn new(problem: &PressedContact, sign: [f64; 2], semi: [f64; 2]) -> Self {
        let semi = Vector2::from(semi);
        let (a, b, c) = (
            problem.schur.m11 * semi.x * semi.x,
            problem.schur.m12 * semi.x * semi.y,
            problem.schur.m22 * semi.y * semi.y,
        );
        let (mean, half) = (0.5 * (a + c), 0.5 * (a - c));
        let radius = half.hypot(b);
        let large = mean + radius;
        let small = if large > 0.0 { ((a * c - b * b) / large).max(0.0) } else { 0.0 };
        let axis = if half >= 0.0 {
            Vector2::new(half + radius, b)
        } else {
            Vector2::new(b, radius - half)
        };
        let axis = axis.try_normalize(0.0).unwrap_or_else(Vector2::x);
        let axes = Matrix2::new(axis.x, -axis.y, axis.y, axis.x);
        Self {
            sign,
            semi,
            axes,
            eigenvalues: Vector2::new(large, small),
            slip: axes.tr_mul(&semi.component_mul(&problem.slip)),
            pull: axes.tr_mul(&semi.component_mul(&problem.pull)),
        }
    }

    /// `z` along the eigenvectors, N s, for a strength of friction `alpha`, 1/kg.
    fn solution(&self, alpha: f64) -> Vector2<f64> {
        -self.slip.component_div(&self.eigenvalues.add_scalar(alpha))
    }

    /// Friction along `t1` and `t2`, N s, of `z` along the eigenvectors.
    fn friction(&self, z: &Vector2<f64>) -> Vector2<f64> {
        self.semi.component_mul(&(self.axes * z))
    }

    /// Distance of the friction from this quarter, N s; on an axis of length zero, the friction
    /// that it would take to stop a slip that the other side resists.
    fn outside(&self, problem: &PressedContact, alpha: f64) -> f64 {
        let friction = self.friction(&self.solution(alpha));
        let slip = problem.schur * friction + problem.slip;
        let outside = |i: usize| {
            let toward =
                if self.semi[i] > 0.0 { friction[i] } else { -slip[i] / problem.schur[(i, i)] };
            (-self.sign[i] * toward).max(0.0)
        };
        outside(0).max(outside(1))
    }
}

/// Quarter in which the friction lies: there is one, since for a given `alpha` the problem is
/// strictly convex with a continuous gradient.
fn containing<'a>(
    problem: &PressedContact,
    quarters: &'a [CurveQuarter],
    alpha: f64,
) -> &'a CurveQuarter {
    let mut best = &quarters[0];
    if quarters.len() > 1 {
        let mut least = f64::INFINITY;
        for quarter in quarters {
            let outside = quarter.outside(problem, alpha);
            if outside < least {
                (best, least) = (quarter, outside);
            }
        }
    }
    best
}
