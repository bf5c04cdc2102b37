//! How far impulses and velocities are from the law.
use crate::{Contact, Report};
use nalgebra::{Vector2, Vector3};
use rayon::prelude::*;
use std::borrow::Borrow;

/// Contacts that one task takes.
const CHUNK: usize = 1024;

/// How far one contact is from its law.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Violation {
    /// Natural map in impulses, N s: the distance of the impulse from the projection onto its cone
    /// of the impulse less weight times velocity, with de Saxcé's term added to the velocity.
    pub impulse: f64,
    /// Error of the normal velocity, m/s: how fast the gap closes, or opens although it is pressed.
    pub normal: f64,
    /// Slip that the friction does not allow, m/s: all of it while the friction is within its
    /// limit, as far as more friction could hold it back. Where the friction is at its limit but not
    /// straight against the slip, only the natural map tells.
    pub slip: f64,
}

impl Violation {
    /// `velocity` is the relative velocity `u` while `impulse` acts, bias and compliance included;
    /// `weight > 0` (kg) makes an impulse of a velocity: take three divided by the trace of the
    /// contact's own response. All three measures are zero where the law holds, and the
    /// natural map nowhere else.
    ///
    /// Costs one projection onto the cone and one onto the curve.
    #[must_use]
    pub fn new(
        contact: &Contact,
        velocity: &Vector3<f64>,
        impulse: &Vector3<f64>,
        weight: f64,
    ) -> Self {
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
}

/// [`Violation::slip`] alone, at half the cost of all: zero, too, where a contact opens and bears nothing.
pub(crate) fn slip_error(
    contact: &Contact,
    velocity: &Vector3<f64>,
    impulse: &Vector3<f64>,
    weight: f64,
) -> f64 {
    let (friction, slip) = (impulse.yz(), velocity.yz());
    let limit = (impulse.x + contact.adhesion).max(0.0);
    let allowed = contact.friction.project(&(friction - slip * weight), limit);
    along(&(friction - allowed), &slip) / weight
}

/// How far `missing` goes along a direction; zero where that is none.
fn along(missing: &Vector2<f64>, direction: &Vector2<f64>) -> f64 {
    direction.try_normalize(0.0).map_or(0.0, |direction| missing.dot(&direction).max(0.0))
}

/// The report on all contacts: the residual is the norm of all natural maps divided by that of all
/// impulses, from the cones' tips; the velocity errors are the largest. Iterations and convergence
/// are left for the solver to tell.
///
/// Arrays are by contact, or reference to one, as in [`Violation::new`]; of unequal lengths the shortest
/// counts.
#[must_use]
pub fn report<C: Borrow<Contact> + Sync>(
    contacts: &[C],
    velocities: &[Vector3<f64>],
    impulses: &[Vector3<f64>],
    weights: &[f64],
) -> Report {
    let count = contacts.len().min(velocities.len()).min(impulses.len()).min(weights.len());
    let part = |start: usize| {
        let mut report = Report::default();
        let (mut residual, mut size) = (0.0, 0.0);
        for i in start..count.min(start + CHUNK) {
            let (contact, r) = (contacts[i].borrow(), &impulses[i]);
            let violation = Violation::new(contact, &velocities[i], r, weights[i]);
            residual += violation.impulse * violation.impulse;
            size += (r + Vector3::new(contact.adhesion, 0.0, 0.0)).norm_squared();
            report.normal_error = report.normal_error.max(violation.normal);
            report.slip_error = report.slip_error.max(violation.slip);
        }
        (report, residual, size)
    };
    let starts: Vec<usize> = (0..count).step_by(CHUNK).collect();
    // Summed in the order of the contacts, whoever computes the parts.
    let parts: Vec<_> = starts.into_par_iter().map(part).collect();
    let mut report = Report::default();
    let (mut residual, mut size) = (0.0, 0.0);
    for (part, wrong, all) in parts {
        residual += wrong;
        size += all;
        report.normal_error = report.normal_error.max(part.normal_error);
        report.slip_error = report.slip_error.max(part.slip_error);
    }
    // Without any impulse the map itself is the measure: all wrong, or nothing.
    let size: f64 = if size > 0.0 { size } else { residual };
    report.residual = if residual > 0.0 { (residual / size).sqrt() } else { 0.0 };
    report
}
