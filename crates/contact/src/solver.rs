use crate::{Body, Contact, ContactError};
use nalgebra::Vector3;
use rayon::prelude::*;

/// Bounds at which a solver stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Largest Coulomb residual, relative to all impulses.
    pub residual: f64,
    /// Largest error of a normal velocity, m/s.
    pub normal: f64,
    /// Largest slip of a contact that sticks, m/s.
    pub slip: f64,
    /// Most iterations.
    pub iterations: usize,
}

impl Tolerance {
    /// For single bodies and tests: to a relative residual of 1e-12.
    pub const EXACT: Self =
        Self { residual: 1e-12, normal: f64::INFINITY, slip: f64::INFINITY, iterations: 20_000 };

    /// Largest of the errors found, in tolerances: at most one where all are kept.
    #[must_use]
    pub fn error(&self, found: &Report) -> f64 {
        let normal = found.normal_error / self.normal;
        (found.residual / self.residual).max(normal).max(found.slip_error / self.slip)
    }

    /// Whether all errors found are within the bounds.
    pub(crate) fn reached(&self, found: &Report) -> bool {
        self.error(found) <= 1.0
    }
}

/// Errors against the law of contacts, and the iterations spent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Report {
    /// Number of iterations.
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

/// Impulse on each of a number of `points`, N s, world, of `impulses` of contacts, in their frames.
pub(crate) fn on_points(
    contacts: &[Contact],
    impulses: &[Vector3<f64>],
    points: usize,
) -> Vec<Vector3<f64>> {
    let mut on_points = vec![Vector3::zeros(); points];
    for (contact, impulse) in contacts.iter().zip(impulses) {
        let world = contact.frame * impulse;
        on_points[contact.first] += world;
        if let Some(second) = contact.second {
            on_points[second] -= world;
        }
    }
    on_points
}

/// Velocities of the points after changes of the contacts' impulses, all of which fit.
pub(crate) fn respond(
    bodies: &mut [&mut dyn Body],
    contacts: &[Contact],
    velocities: &[Vector3<f64>],
    changes: &[Vector3<f64>],
) -> Vec<Vector3<f64>> {
    let on_points = on_points(contacts, changes, velocities.len());
    let mut after = velocities.to_vec();
    let mut start = 0;
    for body in bodies {
        let count = body.points();
        let mut answer = vec![Vector3::zeros(); count];
        body.respond(&on_points[start..start + count], &mut answer);
        for (velocity, change) in after[start..].iter_mut().zip(answer) {
            *velocity += change;
        }
        start += count;
    }
    after
}

/// Refuses arrays that do not fit and contacts that make no sense.
pub(crate) fn check(
    bodies: &[&mut dyn Body],
    contacts: &[Contact],
    velocities: &[Vector3<f64>],
    impulses: &[Vector3<f64>],
) -> Result<(), ContactError> {
    let points = bodies.iter().map(|body| body.points()).sum();
    let lengths =
        [("velocities", points, velocities.len()), ("impulses", contacts.len(), impulses.len())];
    for (what, expected, found) in lengths {
        if expected != found {
            return Err(ContactError::Length { what, expected, found });
        }
    }
    contacts
        .par_iter()
        .enumerate()
        .map(|(i, contact)| contact.validate(i, points))
        .collect::<Result<(), _>>()?;
    let finite = |v: &Vector3<f64>| v.iter().all(|x| x.is_finite());
    if velocities.par_iter().all(finite) && impulses.par_iter().all(finite) {
        return Ok(());
    }
    Err(ContactError::Invalid {
        what: "a velocity or impulse",
        value: f64::NAN,
        why: "all must be finite (m/s, N s)",
    })
}
