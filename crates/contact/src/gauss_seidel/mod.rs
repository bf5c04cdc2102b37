//! Block Gauss-Seidel where it is needed: contacts that are right are passed over.
//!
//! A queue has those that may be wrong, at first all. Whichever is first in it is looked at, and if it is
//! wrong it is solved exactly while the others' impulses stay; those whose velocities have changed since they
//! were looked at are looked at again. From a good guess most are never solved, and what is wrong in one
//! place costs nothing in others: so Southwell (1940) relaxed by hand, with more care for the order.

mod delassus;
mod queue;
mod search;

use crate::{Body, Contact, ContactError, Report, Solver, Tolerance};
use delassus::finite;
use nalgebra::Vector3;
use search::ImpulseSearch;

pub(crate) use delassus::Delassus;

/// Block Gauss-Seidel: one contact after the other is solved exactly while the others' impulses
/// stay, at first in the order of their first points (root to tip), until all obey the law.
///
/// It knows every answer explicitly and solves every limit curve exactly. An iteration is as many solved
/// contacts as there are. Where bodies do not [write out](Body::written_out) their answers, memory and setup
/// grow with the square of their touched points; to solve a contact costs six columns: many contacts per fiber
/// want [`Solver`]s that do without.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussSeidel {
    /// When to stop.
    pub tolerance: Tolerance,
    /// By how much of its change an impulse is replaced, more than zero and less than two; above
    /// one where many contacts support each other.
    pub relaxation: f64,
    /// It gives up where so many iterations leave no fewer contacts wrong than were before;
    /// [`usize::MAX`] for never. Contacts that hold each other may be solved round and round.
    pub patience: usize,
}

impl GaussSeidel {
    /// The solver without relaxation, which does not give up before its last iteration.
    #[must_use]
    pub fn new(tolerance: Tolerance) -> Self {
        Self { tolerance, relaxation: 1.0, patience: usize::MAX }
    }

    fn validate(&self) -> Result<(), ContactError> {
        let Tolerance { residual, normal, slip, .. } = self.tolerance;
        let checks = [
            ("tolerance of the residual", residual, f64::INFINITY),
            ("tolerance of normal velocities", normal, f64::INFINITY),
            ("tolerance of slip", slip, f64::INFINITY),
            ("relaxation", self.relaxation, 2.0_f64.next_down()),
        ];
        match checks.into_iter().find(|&(_, value, bound)| !(value > 0.0 && value <= bound)) {
            Some((what, value, _)) => Err(ContactError::Invalid {
                what,
                value,
                why: "it must be positive, a relaxation less than two",
            }),
            None => Ok(()),
        }
    }
}

impl Solver for GaussSeidel {
    fn solve(
        &mut self,
        bodies: &mut [&mut dyn Body],
        contacts: &[Contact],
        velocities: &[Vector3<f64>],
        impulses: &mut [Vector3<f64>],
    ) -> Result<Report, ContactError> {
        self.validate()?;
        if impulses.len() != contacts.len() {
            return Err(ContactError::Length {
                what: "impulses of contacts",
                expected: contacts.len(),
                found: impulses.len(),
            });
        }
        finite("component of a starting impulse", impulses)?;
        let delassus = Delassus::new(bodies, contacts, velocities)?;
        Ok(ImpulseSearch::new(self, delassus, contacts, impulses).run(impulses))
    }
}
