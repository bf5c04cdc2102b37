//! How far impulses and velocities are from the law.
use crate::{Contact, Report};
use nalgebra::{Vector2, Vector3};
use rayon::prelude::*;
use std::borrow::Borrow;

/// Joints that open more slowly than this, m/s, bear what they must: where that is nothing, what is
/// left of it is rounding, to which no error compares.
pub(crate) const JOINT_CLOSED: f64 = 1e-10;

/// Contacts of a report that one task takes.
const CHUNK: usize = 1024;

/// Masses, kg, by which errors of a contact are judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorMasses {
    /// The contact's own, that of [`Violation::new`].
    pub own: f64,
    /// Mass of the heaviest that moves with it, at least its own. Of the same error of a velocity
    /// it makes a larger one of the impulses, as what bears on both sides can be.
    pub moved: f64,
}

impl From<f64> for ErrorMasses {
    fn from(own: f64) -> Self {
        Self { own, moved: own }
    }
}

/// Distance of one contact from its law.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Violation {
    /// Natural map in impulses, N s: the distance of the impulse from the projection onto its cone
    /// of the impulse less weight times velocity, with de Saxcé's term added to the velocity.
    pub impulse: f64,
    /// Error of the normal velocity, m/s: how fast the gap closes, or opens although it is pressed.
    pub normal: f64,
    /// Slip that the friction does not allow, m/s: all of it while the friction is within its
    /// limit, as far as more friction could hold it back. Where the friction is at its limit but
    /// not straight against the slip, only the natural map tells.
    pub slip: f64,
}

impl Violation {
    /// Violation of one contact. `velocity` is the relative velocity `u` while `impulse` acts, bias
    /// and compliance included; `weight > 0` (kg) makes an impulse of a velocity: take three
    /// divided by the trace of the contact's own response. All three measures are zero where the
    /// law holds, and the natural map nowhere else.
    ///
    /// Costs one projection onto the cone and one onto the curve.
    #[must_use]
    pub fn new(
        contact: &Contact,
        velocity: &Vector3<f64>,
        impulse: &Vector3<f64>,
        weight: f64,
    ) -> Self {
        if contact.is_joint() {
            return Self::of_joint(velocity, weight);
        }
        if *impulse == Vector3::zeros() && contact.adhesion == 0.0 && velocity.x >= 0.0 {
            // What opens and bears nothing is right, as are most contacts of a long list.
            return Self::default();
        }
        let curve = &contact.friction;
        // From the cone's tip.
        let r = impulse + Vector3::new(contact.adhesion, 0.0, 0.0);
        let saxce = Vector3::new(curve.dissipation(&velocity.yz()), 0.0, 0.0);
        let projected = curve.project_cone(&(r - (velocity + saxce) * weight));
        Self {
            impulse: (r - projected).norm(),
            normal: velocity.x.min(r.x / weight).abs(),
            slip: slip_error(contact, velocity, impulse, weight),
        }
    }

    /// Violation of a joint: all that opens it is a slip, and an error of the impulse if it is more
    /// than [`JOINT_CLOSED`].
    fn of_joint(velocity: &Vector3<f64>, weight: f64) -> Self {
        let slip = velocity.norm();
        Self { impulse: if slip > JOINT_CLOSED { slip * weight } else { 0.0 }, normal: 0.0, slip }
    }

    /// The part of a slip that the friction does not allow, m/s along the two tangents, with the
    /// arguments of [`Violation::new`]: all of it while the friction is within its limit and could
    /// hold it back, none of it while a contact slides by the law.
    #[must_use]
    pub fn forbidden_slip(
        contact: &Contact,
        velocity: &Vector3<f64>,
        impulse: &Vector3<f64>,
        weight: f64,
    ) -> Vector2<f64> {
        missing(contact, velocity, impulse, weight) / weight
    }
}

/// [`Violation::slip`]: zero, too, where a contact opens and bears nothing.
fn slip_error(
    contact: &Contact,
    velocity: &Vector3<f64>,
    impulse: &Vector3<f64>,
    weight: f64,
) -> f64 {
    along(&missing(contact, velocity, impulse, weight), &velocity.yz()) / weight
}

/// Whether [`Violation::slip`] is more than a bound: without a root or a quotient.
#[inline(always)]
pub(crate) fn slips(
    contact: &Contact,
    velocity: &Vector3<f64>,
    impulse: &Vector3<f64>,
    weight: f64,
    bound: f64,
) -> bool {
    let slip = velocity.yz();
    let product = missing(contact, velocity, impulse, weight).dot(&slip);
    let bound = bound * weight;
    product > 0.0 && product * product > bound * bound * slip.norm_squared()
}

/// Friction that would hold a slip back further, as far as its limit lets it, N s.
#[inline(always)]
fn missing(
    contact: &Contact,
    velocity: &Vector3<f64>,
    impulse: &Vector3<f64>,
    weight: f64,
) -> Vector2<f64> {
    let limit = (impulse.x + contact.adhesion).max(0.0);
    let more = impulse.yz() - velocity.yz() * weight;
    impulse.yz() - contact.friction.project(&more, limit)
}

/// Component of `missing` along a direction; zero where that is against it or there is none.
fn along(missing: &Vector2<f64>, direction: &Vector2<f64>) -> f64 {
    let product = missing.dot(direction);
    if product > 0.0 { product / direction.norm() } else { 0.0 }
}

/// Report on all contacts: the residual is the norm of all natural maps divided by that of all
/// impulses, from the cones' tips; the velocity errors are the largest. Iterations and convergence
/// are left for the solver to tell. Where an impulse or a velocity is not finite all three are
/// infinite.
///
/// `one` tells of each of `count` contacts what [`Violation::new`] asks for, the contact, its
/// velocity, impulse and weight; or instead of the weight both masses, by whose ratio its natural
/// map then counts more.
#[must_use]
pub fn report<C: Borrow<Contact>, M: Into<ErrorMasses>>(
    count: usize,
    one: impl Fn(usize) -> (C, Vector3<f64>, Vector3<f64>, M) + Sync,
) -> Report {
    let part = |start: usize| {
        let mut sums = ResidualSums::default();
        for (contact, velocity, impulse, masses) in (start..count.min(start + CHUNK)).map(&one) {
            sums.add(contact.borrow(), &velocity, &impulse, masses.into());
        }
        sums
    };
    let starts: Vec<usize> = (0..count).step_by(CHUNK).collect();
    let parts: Vec<_> = starts.into_par_iter().map(part).collect();
    // In the order of the contacts, whoever computes the parts.
    ResidualSums::sum(&parts).report()
}

/// Sums and largest values that a report is made of.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ResidualSums {
    /// Sum of the squares of the natural maps, (N s)^2.
    pub(crate) residual_squares: f64,
    /// Sum of the squares of the impulses from the cones' tips, (N s)^2.
    pub(crate) impulse_squares: f64,
    /// Largest error of a normal velocity, m/s.
    pub(crate) normal_error: f64,
    /// Largest slip that the friction does not allow, m/s.
    pub(crate) slip_error: f64,
}

impl ResidualSums {
    /// Adds the [`Violation`] of a contact.
    fn add(
        &mut self,
        contact: &Contact,
        velocity: &Vector3<f64>,
        impulse: &Vector3<f64>,
        ErrorMasses { own, moved }: ErrorMasses,
    ) {
        let violation = Violation::new(contact, velocity, impulse, own);
        let error = violation.impulse * (moved / own);
        self.residual_squares += error * error;
        self.impulse_squares += (impulse + Vector3::new(contact.adhesion, 0.0, 0.0)).norm_squared();
        self.normal_error = self.normal_error.max(violation.normal);
        self.slip_error = self.slip_error.max(violation.slip);
    }

    /// Sums and largest values over all parts, in their order.
    pub(crate) fn sum(parts: &[Self]) -> Self {
        parts.iter().fold(Self::default(), |sum, part| Self {
            residual_squares: sum.residual_squares + part.residual_squares,
            impulse_squares: sum.impulse_squares + part.impulse_squares,
            normal_error: sum.normal_error.max(part.normal_error),
            slip_error: sum.slip_error.max(part.slip_error),
        })
    }

    /// Report of the sums. Without any impulse the natural maps are the measure: all is wrong, or
    /// nothing.
    pub(crate) fn report(&self) -> Report {
        let Self { residual_squares: wrong, impulse_squares: all, normal_error, slip_error } =
            *self;
        let all = if all > 0.0 { all } else { wrong };
        if !(wrong.is_finite() && all.is_finite()) {
            let [residual, normal_error, slip_error] = [f64::INFINITY; 3];
            return Report { residual, normal_error, slip_error, ..Report::default() };
        }
        let residual = if wrong > 0.0 { (wrong / all).sqrt() } else { 0.0 };
        Report { residual, normal_error, slip_error, ..Report::default() }
    }
}
