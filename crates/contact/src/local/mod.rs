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
    LocalProblem::new(contact, response).solve(contact, free)
}

/// What a contact and its own answer are, whatever the velocity.
pub(crate) struct LocalProblem {
    pub(crate) response: Matrix3<f64>,
    /// What keeps it from being singular, added to its diagonal.
    softness: Vector3<f64>,
    /// `None` where nothing can move.
    factors: Option<Factors>,
}

impl LocalProblem {
    pub(crate) fn new(contact: &Contact, response: &Matrix3<f64>) -> Self {
        let mut local = Self { response: *response, softness: Vector3::zeros(), factors: None };
        let bare = local.bare(contact);
        let trace = bare.trace();
        if trace > 0.0 {
            local.softness = softness(&bare, SOFTNESS * trace);
            local.factors = Some(Factors::new(&(bare + Matrix3::from_diagonal(&local.softness))));
        }
        local
    }

    /// The response with the contact's compliance.
    #[inline(always)]
    fn bare(&self, contact: &Contact) -> Matrix3<f64> {
        self.response + Matrix3::from_diagonal_element(contact.compliance)
    }

    /// See [`solve_contact`].
    #[inline(always)]
    pub(crate) fn solve(&self, contact: &Contact, free: &Vector3<f64>) -> Vector3<f64> {
        let Self { softness, factors: Some(factors), .. } = self else {
            return Vector3::zeros();
        };
        let bare = self.bare(contact);
        // The cone's tip is at -adhesion: from there the law is the same without adhesion.
        let tip = Vector3::new(contact.adhesion, 0.0, 0.0);
        let free = free - bare * tip;
        if free.x >= 0.0 {
            return -tip;
        }
        let mut sticking = factors.stick(&free);
        if *softness != Vector3::zeros() {
            // What was added leaves a rest of the slip, which this takes away.
            for _ in 0..2 {
                sticking += factors.stick(&(bare * sticking + free));
            }
        }
        if sticking.x >= 0.0 && contact.friction.contains(&sticking.yz(), sticking.x) {
            return sticking - tip;
        }
        slide(contact, &(bare + Matrix3::from_diagonal(softness)), &free) - tip
    }
}

/// The impulse of a contact that must slide, from the cone's tip.
fn slide(contact: &Contact, w: &Matrix3<f64>, free: &Vector3<f64>) -> Vector3<f64> {
    if let LimitCurve::Polygon(curve) = &contact.friction {
        return polygon::slide(w, free, curve);
    }
    let problem = Pressed::new(w, free);
    let slid = smooth::slide(&problem, &contact.friction.semi_axes().unwrap_or_default());
    // A response near singular leaves rounding that the cone need not bear.
    let friction = contact.friction.project(&slid.yz(), slid.x);
    Vector3::new(slid.x, friction.x, friction.y)
}

/// What diagonal elements need whose pivots are no more than rounding: `enough` for each.
fn softness(w: &Matrix3<f64>, enough: f64) -> Vector3<f64> {
    let mut softness = Vector3::zeros();
    let mut left = *w;
    for i in 0..3 {
        if left[(i, i)] <= ROUNDING * w[(i, i)] {
            left[(i, i)] += enough;
            softness[i] = enough;
        }
        for j in i + 1..3 {
            let factor = left[(j, i)] / left[(i, i)];
            for k in i + 1..3 {
                left[(j, k)] -= factor * left[(i, k)];
            }
        }
    }
    softness
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
}

/// A positive definite matrix of three, the normal eliminated first and then, of the tangents, that with the
/// larger pivot.
struct Factors {
    coupling: Vector2<f64>,
    pull: Vector2<f64>,
    swapped: bool,
    factor: f64,
    between: f64,
    /// One divided by each pivot.
    pivots: Vector3<f64>,
}

impl Factors {
    fn new(w: &Matrix3<f64>) -> Self {
        let Pressed { schur, pull, .. } = Pressed::new(w, &Vector3::zeros());
        let swapped = schur.m11 < schur.m22;
        let (first, second) = if swapped { (schur.m22, schur.m11) } else { (schur.m11, schur.m22) };
        let (between, factor) = (schur.m12, schur.m12 / first);
        let pivots = Vector3::new(w.m11, first, second - factor * between).map(f64::recip);
        Self { coupling: Vector2::new(w.m12, w.m13), pull, swapped, factor, between, pivots }
    }

    /// The impulse that stops all motion.
    #[inline(always)]
    fn stick(&self, free: &Vector3<f64>) -> Vector3<f64> {
        let order = |v: Vector2<f64>| if self.swapped { v.yx() } else { v };
        let load = -free.x * self.pivots.x;
        let slip = order(free.yz() + self.coupling * load);
        let second = (self.factor * slip.x - slip.y) * self.pivots.z;
        let first = -(slip.x + self.between * second) * self.pivots.y;
        let friction = order(Vector2::new(first, second));
        Vector3::new(load + self.pull.dot(&friction), friction.x, friction.y)
    }
}
