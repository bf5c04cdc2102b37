use crate::contact::free_solve;
use crate::{Body, Contact, ContactError};
use nalgebra::Vector3;

/// How well a law is obeyed, and what that cost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Report {
    /// Iterations.
    pub iterations: usize,
    /// Whether the solver's tolerances were reached.
    pub converged: bool,
    /// Coulomb residual: the natural map of the law in impulses, relative to all impulses.
    pub residual: f64,
    /// Largest error of a normal velocity, m/s: how fast a gap closes that must not, or opens
    /// although it is pressed.
    pub normal_error: f64,
    /// Largest slip of a contact whose friction is within its limit, m/s.
    pub slip_error: f64,
}

/// Solves all contacts of some bodies together.
pub trait Solver: Send {
    /// Finds the impulses of `contacts` (N s, in each contact's frame) and replaces `impulses` by
    /// them. `velocities` are those of all points while the impulses given at first act; these
    /// are where the search starts as well.
    ///
    /// # Errors
    /// [`ContactError`] for arrays that do not fit and contacts that make no sense. A search that
    /// ends before its tolerance is no error: the report says so.
    fn solve(
        &mut self,
        bodies: &mut [&mut dyn Body],
        contacts: &[Contact],
        velocities: &[Vector3<f64>],
        impulses: &mut [Vector3<f64>],
    ) -> Result<Report, ContactError>;
}

/// How well impulses and velocities obey the law.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Certificate {
    /// As in [`Report`].
    pub residual: f64,
    /// As in [`Report`].
    pub normal_error: f64,
    /// As in [`Report`].
    pub slip_error: f64,
}

impl Certificate {

    /// Measures `impulses` where the points have the given velocities. `weights` (1/kg) are the
    /// sizes of the contacts' own responses, with which velocities are compared to impulses.
    #[must_use]
    pub fn of(
        contacts: &[Contact],
        weights: &[f64],
        velocities: &[Vector3<f64>],
        impulses: &[Vector3<f64>],
    ) -> Self {
        let (mut wrong, mut all) = (0.0, 0.0);
        let mut found = Self::default();
        for (i, contact) in contacts.iter().enumerate() {
            let (r, w) = (&impulses[i], weights[i]);
            let u = contact.relative(velocities) + r * contact.compliance;
            let other = free_solve(contact, &(u - r * (w + contact.compliance)), w);
            wrong += (r - other).norm_squared();
            all += r.norm_squared();
            let pressed = r.x > -contact.adhesion;
            let normal = if pressed { u.x.abs() } else { (-u.x).max(0.0) };
            found.normal_error = found.normal_error.max(normal);
            if pressed {
                found.slip_error = found.slip_error.max((r.yz() - other.yz()).norm() * w);
            }
        }
        if wrong > 0.0 {
            found.residual = if all > 0.0 { (wrong / all).sqrt() } else { f64::INFINITY };
        }
        found
    }
}

/// Refuses arrays that do not fit and contacts that make no sense.
pub(crate) fn check(
    bodies: &[&mut dyn Body],
    contacts: &[Contact],
    velocities: &[Vector3<f64>],
    impulses: &[Vector3<f64>],
) -> Result<(), ContactError> {
    let points = bodies.iter().map(|body| body.points()).sum();
    let lengths = [
        ("velocities", points, velocities.len()),
        ("impulses", contacts.len(), impulses.len()),
    ];
    for (what, expected, found) in lengths {
        if expected != found {
            return Err(ContactError::Length { what, expected, found });
        }
    }
    for (i, contact) in contacts.iter().enumerate() {
        let refuse = |why| Err(ContactError::Contact { contact: i, why });
        if contact.first >= points || contact.second.is_some_and(|point| point >= points) {
            return refuse("there is no such point");
        }
        if contact.second == Some(contact.first) {
            return refuse("a point cannot touch itself");
        }
        let numbers = contact.frame.iter().chain(&contact.bias).chain(&impulses[i]);
        if !numbers.chain(&[contact.adhesion, contact.compliance]).all(|x| x.is_finite()) {
            return refuse("its numbers must be finite");
        }
        if contact.adhesion < 0.0 || contact.compliance < 0.0 {
            return refuse("adhesion and compliance must not be negative");
        }
    }
    if velocities.iter().flatten().all(|x| x.is_finite()) {
        return Ok(());
    }
    Err(ContactError::Invalid {
        what: "velocities",
        value: f64::NAN,
        why: "must be finite (m/s)",
    })
}
