//! The exact solution of one contact, with any symmetric positive semidefinite response.
use crate::{Contact, LimitCurve};
use nalgebra::{Matrix3, Vector2, Vector3};

mod polygon;
mod pressed_contact;
mod smooth;

use pressed_contact::PressedResponse;
use smooth::SlidingCurve;

/// Pivots smaller than this, relative to their diagonal element, are rounding.
const PIVOT_ROUNDING: f64 = 1e-11;

/// Number added to diagonal elements whose pivots are rounding, relative to the trace.
const SOFTNESS: f64 = 1e-9;

/// Impulse that obeys the law of one contact exactly, N s, in its frame.
///
/// `response` is the 3x3 answer of the relative velocity to the contact's own impulse, 1/kg,
/// without the contact's compliance; `free` is the relative velocity without any impulse of this
/// contact, bias included; both in the contact's frame.
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

/// The part of a contact's local problem that does not depend on its velocity.
pub(crate) struct LocalProblem {
    /// Answer of the relative velocity to the contact's own impulse, 1/kg, in its frame, without
    /// compliance.
    pub(crate) response: Matrix3<f64>,
    /// Additions to the diagonal of the response that keep it regular, 1/kg.
    softness: Vector3<f64>,
    /// Factors of the response with compliance and softness; `None` where nothing can move.
    factors: Option<StickFactors>,
    /// The limit curve as it is slid on, from when that was first asked for.
    sliding: Option<SlidingCurve>,
}

impl LocalProblem {
    /// Local problem of a contact with this response, 1/kg, in its frame.
    pub(crate) fn new(contact: &Contact, response: &Matrix3<f64>) -> Self {
        let none = Vector3::zeros();
        let mut local = Self { response: *response, softness: none, factors: None, sliding: None };
        let bare = local.bare(contact);
        let trace = bare.trace();
        if trace > 0.0 {
            local.softness = softness(&bare, SOFTNESS * trace);
            local.factors =
                Some(StickFactors::new(&(bare + Matrix3::from_diagonal(&local.softness))));
        }
        local
    }

    /// Response with the contact's compliance, 1/kg.
    #[inline(always)]
    fn bare(&self, contact: &Contact) -> Matrix3<f64> {
        self.response + Matrix3::from_diagonal_element(contact.compliance)
    }

    /// Impulse that obeys the law of the contact with the velocity `free`, as [`solve_contact`].
    #[inline(always)]
    pub(crate) fn solve(&mut self, contact: &Contact, free: &Vector3<f64>) -> Vector3<f64> {
        let bare = self.bare(contact);
        let Self { softness, factors: Some(factors), sliding, .. } = self else {
            return Vector3::zeros();
        };
        // The cone's tip is at -adhesion: from there the law is the same without adhesion.
        let tip = Vector3::new(contact.adhesion, 0.0, 0.0);
        let free = free - bare * tip;
        // Take-off: nothing closes the gap.
        let joint = contact.is_joint();
        if free.x >= 0.0 && !joint {
            return -tip;
        }
        // Stick: the impulse that stops all motion, if the friction bears it.
        let mut sticking = factors.stick(&free);
        if *softness != Vector3::zeros() {
            // What was added leaves a rest of the slip, which this takes away.
            for _ in 0..2 {
                sticking += factors.stick(&(bare * sticking + free));
            }
        }
        if joint || sticking.x >= 0.0 && contact.friction.contains(&sticking.yz(), sticking.x) {
            return sticking - tip;
        }
        // Slip: friction at its limit.
        let w = || bare + Matrix3::from_diagonal(softness);
        let slid = match &contact.friction {
            LimitCurve::Polygon(curve) => polygon::slide(&w(), &free, curve),
            friction => {
                let curve = || SlidingCurve::new(&w(), &friction.semi_axes().unwrap_or_default());
                let slid = sliding.get_or_insert_with(curve).slide(&free);
                // A response near singular leaves rounding that the cone need not bear.
                let friction = friction.project(&slid.yz(), slid.x);
                Vector3::new(slid.x, friction.x, friction.y)
            }
        };
        slid - tip
    }
}

/// Additions to the diagonal: `enough` for each element whose pivot is no more than rounding, else
/// zero.
fn softness(w: &Matrix3<f64>, enough: f64) -> Vector3<f64> {
    let mut softness = Vector3::zeros();
    let mut left = *w;
    for i in 0..3 {
        if left[(i, i)] <= PIVOT_ROUNDING * w[(i, i)] {
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

/// Factors of a positive definite response, by which an impulse is found that stops all motion: the
/// normal is eliminated first and then, of the tangents, that with the larger pivot.
struct StickFactors {
    /// Off-diagonal elements of the normal, 1/kg.
    coupling: Vector2<f64>,
    /// Normal impulse per friction.
    pull: Vector2<f64>,
    /// Whether the second tangent is eliminated before the first.
    swapped: bool,
    /// Multiplier of the elimination of the first of the two tangents.
    factor: f64,
    /// Off-diagonal element of the Schur complement, 1/kg.
    between: f64,
    /// Reciprocals of the pivots, kg.
    pivots: Vector3<f64>,
}

impl StickFactors {
    /// Factors of the response `w`, 1/kg.
    fn new(w: &Matrix3<f64>) -> Self {
        let PressedResponse { schur, pull, .. } = PressedResponse::new(w);
        let swapped = schur.m11 < schur.m22;
        let (first, second) = if swapped { (schur.m22, schur.m11) } else { (schur.m11, schur.m22) };
        let (between, factor) = (schur.m12, schur.m12 / first);
        let pivots = Vector3::new(w.m11, first, second - factor * between).map(f64::recip);
        Self { coupling: Vector2::new(w.m12, w.m13), pull, swapped, factor, between, pivots }
    }

    /// Impulse that stops the velocity `free`, m/s, N s.
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
