//! The exact solution of one contact, with any symmetric positive semidefinite response.
use crate::{Contact, LimitCurve};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

mod polygon;
mod smooth;

/// Pivots smaller than this, relative to their diagonal element, are rounding.
const ROUNDING: f64 = 1e-11;

/// What is added to such a diagonal element, relative to the trace.
const SOFTNESS: f64 = 1e-9;

/// The impulse that obeys the law of one contact exactly.
///
/// `response` is the 3x3 answer of the relative velocity to the contact's own impulse, 1/kg, without
/// the contact's compliance; `free` is the relative velocity without any impulse of this contact,
/// bias included; both in the contact's frame.
///
/// There is always a solution. Where there are several (possible if a push along the surface closes
/// the gap, and friction is large: Painlevé), the contact opens if it can, otherwise sticks if it
/// can. If nothing can move, the impulse is zero. Take-off and stick are closed forms; sliding is a
/// bracketed root of one variable on a circle, ellipse or quarter-ellipses, and an enumeration of
/// vertices and edges on a polygon.
#[must_use]
pub fn solve_contact(
    contact: &Contact,
    response: &Matrix3<f64>,
    free: &Vector3<f64>,
) -> Vector3<f64> {
    let mut w = response + Matrix3::from_diagonal_element(contact.compliance);
    let trace = w.trace();
    if trace <= 0.0 || trace.is_nan() {
        return Vector3::zeros();
    }
    // The cone's tip is at -adhesion: from there the law is the same without adhesion.
    let tip = Vector3::new(contact.adhesion, 0.0, 0.0);
    let free = free - w * tip;
    if free.x >= 0.0 {
        return -tip;
    }
    let bare = w;
    let softened = soften(&mut w, SOFTNESS * trace);
    let problem = Pressed::new(&w, &free);
    let mut sticking = problem.stick();
    if softened {
        // What was added leaves a rest of the slip, which this takes away.
        for _ in 0..2 {
            sticking += Pressed::new(&w, &(bare * sticking + free)).stick();
        }
    }
    let impulse = if sticking.x >= 0.0 && contact.friction.contains(&sticking.yz(), sticking.x) {
        sticking
    } else if let LimitCurve::Polygon(curve) = &contact.friction {
        polygon::slide(&w, &free, curve)
    } else {
        let slid = smooth::slide(&problem, &contact.friction.semi_axes().unwrap_or_default());
        // A response near singular leaves rounding that the cone need not bear.
        let friction = contact.friction.project(&slid.yz(), slid.x);
        Vector3::new(slid.x, friction.x, friction.y)
    };
    impulse - tip
}

/// Adds `softness` to diagonal elements whose pivots are no more than rounding; tells whether there
/// were any.
fn soften(w: &mut Matrix3<f64>, softness: f64) -> bool {
    let mut found = false;
    let mut left = *w;
    for i in 0..3 {
        if left[(i, i)] <= ROUNDING * w[(i, i)] {
            w[(i, i)] += softness;
            left[(i, i)] += softness;
            found = true;
        }
        for j in i + 1..3 {
            let factor = left[(j, i)] / left[(i, i)];
            for k in i + 1..3 {
                left[(j, k)] -= factor * left[(i, k)];
            }
        }
    }
    found
}

/// A contact that is pressed, its normal impulse eliminated by `u_n = 0`: friction `x` causes the
/// slip `schur x + slip` and needs the normal impulse `load + pull x`.
struct Pressed {
    schur: Matrix2<f64>,
    slip: Vector2<f64>,
    load: f64,
    pull: Vector2<f64>,
}

impl Pressed {
    fn new(w: &Matrix3<f64>, free: &Vector3<f64>) -> Self {
        let coupling = Vector2::new(w.m12, w.m13);
        let pull = -coupling / w.m11;
        let load = -free.x / w.m11;
        let tangential = Matrix2::new(w.m22, w.m23, w.m23, w.m33);
        Self {
            schur: tangential + coupling * pull.transpose(),
            slip: free.yz() + coupling * load,
            load,
            pull,
        }
    }

    fn normal(&self, friction: &Vector2<f64>) -> f64 {
        self.load + self.pull.dot(friction)
    }

    /// The impulse that stops all motion.
    fn stick(&self) -> Vector3<f64> {
        let friction = solve_symmetric(&self.schur, &-self.slip);
        Vector3::new(self.normal(&friction), friction.x, friction.y)
    }
}

/// Solves a positive definite system of two, in the order of its pivots.
fn solve_symmetric(a: &Matrix2<f64>, b: &Vector2<f64>) -> Vector2<f64> {
    let by_first = |a11: f64, a12: f64, a22: f64, b1: f64, b2: f64| {
        let factor = a12 / a11;
        let second = (b2 - factor * b1) / (a22 - factor * a12);
        ((b1 - a12 * second) / a11, second)
    };
    if a.m11 >= a.m22 {
        let (x, y) = by_first(a.m11, a.m12, a.m22, b.x, b.y);
        Vector2::new(x, y)
    } else {
        let (y, x) = by_first(a.m22, a.m12, a.m11, b.y, b.x);
        Vector2::new(x, y)
    }
}
