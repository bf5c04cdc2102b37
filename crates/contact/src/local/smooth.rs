//! Sliding on a curve of quarter-ellipses with semi-axes `d`.
//!
//! With `x = d z` the curve is the unit circle. Slip against friction, of any strength `alpha`, is
//! `d (schur x + slip) = -alpha z`: for `alpha` from zero to infinity the friction goes from that
//! which sticks, outside its limit, to none, inside. In between `|z|` equals the normal impulse.
use super::pressed_contact::{PressedContact, PressedResponse};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Steps after which the bracket is taken as it is; a dozen are usual.
const MAX_STEPS: usize = 200;

/// Limit curve of a contact that slides, with how its friction is answered: what does not depend on
/// its velocity.
pub(super) struct SlidingCurve {
    response: PressedResponse,
    /// Largest semi-axis.
    size: f64,
    /// The curve's quarter with positive components, which stands for all where opposite ones are
    /// alike.
    first: CurveQuarter,
    /// The other three quarters where they are not.
    others: Vec<CurveQuarter>,
}

impl SlidingCurve {
    /// The curve with the coefficients of friction `mu` along `t1`, `-t1`, `t2`, `-t2`, of a
    /// contact with the response `w`, 1/kg, in its frame.
    pub(super) fn new(w: &Matrix3<f64>, mu: &[f64; 4]) -> Self {
        let response = PressedResponse::new(w);
        let quarter = |sign, semi| CurveQuarter::new(&response, sign, semi);
        let first = quarter([1.0, 1.0], [mu[0], mu[2]]);
        let others = if mu[0] == mu[1] && mu[2] == mu[3] {
            Vec::new()
        } else {
            vec![
                quarter([1.0, -1.0], [mu[0], mu[3]]),
                quarter([-1.0, 1.0], [mu[1], mu[2]]),
                quarter([-1.0, -1.0], [mu[1], mu[3]]),
            ]
        };
        Self { size: mu.iter().copied().fold(0.0, f64::max), response, first, others }
    }

    /// Impulse of the contact with a free velocity, m/s, in its frame, that must slide, N s, from
    /// the cone's tip: the root in `alpha` of `r_n = |z|`, by Newton's method in a bracket.
    pub(super) fn slide(&self, free: &Vector3<f64>) -> Vector3<f64> {
        let Self { response, size, .. } = self;
        let pressed = response.at(free);
        let (pull, load) = (&response.pull, pressed.load);
        let drive = size * pressed.slip.norm();
        // Bracket of the root and a first guess.
        let mut low = 0.0;
        let mut high = drive * (1.0 + size * pull.norm()) / load;
        // Where both tangents answer alike this is the root.
        let square = size * size;
        let mut alpha = (drive + square * pull.dot(&pressed.slip)) / load
            - 0.5 * square * response.schur.trace();
        let mut point = Vector2::zeros();
        let mut quarter = (&self.first, self.first.along_axes(&pressed.slip));
        for _ in 0..MAX_STEPS {
            if !(alpha > low && alpha < high) {
                alpha = if high > 16.0 * low && low > 0.0 {
                    (low * high).sqrt()
                } else {
                    0.5 * (low + high)
                };
            }
            if !self.others.is_empty() {
                quarter = self.containing(&pressed, alpha);
            }
            let (quarter, slip) = &quarter;
            let z = quarter.solution(slip, alpha);
            point = quarter.friction(&z);
            let norm = z.norm();
            if norm <= 0.0 || norm.is_nan() {
                // Nothing resists any slip.
                return Vector3::new(load, 0.0, 0.0);
            }
            // Normal impulse divided by |z|, less one: linear in alpha where both tangents answer
            // alike.
            let normal = load + quarter.pull.dot(&z);
            let excess = normal / norm - 1.0;
            let change = -z.component_div(&quarter.eigenvalues.add_scalar(alpha));
            let slope =
                (quarter.pull.dot(&change) - normal * z.dot(&change) / (norm * norm)) / norm;
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
        Vector3::new(load + pull.dot(&point), point.x, point.y)
    }

    /// Quarter in which the friction lies, with the slip along its axes, m/s: there is one, since
    /// for a given `alpha` the problem is strictly convex with a continuous gradient.
    fn containing(&self, pressed: &PressedContact, alpha: f64) -> (&CurveQuarter, Vector2<f64>) {
        let mut best = (&self.first, self.first.along_axes(&pressed.slip));
        let mut least = f64::INFINITY;
        for quarter in std::iter::once(&self.first).chain(&self.others) {
            let slip = quarter.along_axes(&pressed.slip);
            let friction = quarter.friction(&quarter.solution(&slip, alpha));
            let outside = quarter.outside(&self.response, &pressed.slip, &friction);
            if outside < least {
                (best, least) = ((quarter, slip), outside);
            }
        }
        best
    }
}

/// The problem in one quarter, in the eigenvectors of the answer to `z`: exact for small
/// eigenvalues also.
struct CurveQuarter {
    /// Signs of the friction's components.
    sign: [f64; 2],
    /// Semi-axes `d` of the ellipse.
    semi: Vector2<f64>,
    /// Eigenvectors, in columns.
    axes: Matrix2<f64>,
    /// Eigenvalues, 1/kg.
    eigenvalues: Vector2<f64>,
    /// Normal impulse per `z`, along the eigenvectors.
    pull: Vector2<f64>,
}

impl CurveQuarter {
    /// The problem in the quarter with these signs and semi-axes.
    fn new(response: &PressedResponse, sign: [f64; 2], semi: [f64; 2]) -> Self {
        let semi = Vector2::from(semi);
        let (a, b, c) = (
            response.schur.m11 * semi.x * semi.x,
            response.schur.m12 * semi.x * semi.y,
            response.schur.m22 * semi.y * semi.y,
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
            pull: axes.tr_mul(&semi.component_mul(&response.pull)),
        }
    }

    /// A slip without friction, m/s, scaled by `d`, along the eigenvectors.
    fn along_axes(&self, slip: &Vector2<f64>) -> Vector2<f64> {
        self.axes.tr_mul(&self.semi.component_mul(slip))
    }

    /// `z` along the eigenvectors, N s, of such a slip, for a strength of friction `alpha`, 1/kg.
    fn solution(&self, slip: &Vector2<f64>, alpha: f64) -> Vector2<f64> {
        -slip.component_div(&self.eigenvalues.add_scalar(alpha))
    }

    /// Friction along `t1` and `t2`, N s, of `z` along the eigenvectors.
    fn friction(&self, z: &Vector2<f64>) -> Vector2<f64> {
        self.semi.component_mul(&(self.axes * z))
    }

    /// Distance of a friction, N s, from this quarter; on an axis of length zero, the friction that
    /// it would take to stop a slip that the other side resists. `slip` is that without friction,
    /// m/s.
    fn outside(
        &self,
        response: &PressedResponse,
        slip: &Vector2<f64>,
        friction: &Vector2<f64>,
    ) -> f64 {
        let slip = response.schur * friction + slip;
        let outside = |i: usize| {
            let toward =
                if self.semi[i] > 0.0 { friction[i] } else { -slip[i] / response.schur[(i, i)] };
            (-self.sign[i] * toward).max(0.0)
        };
        outside(0).max(outside(1))
    }
}
