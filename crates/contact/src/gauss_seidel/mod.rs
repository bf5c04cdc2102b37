//! Block Gauss-Seidel where it is needed: contacts that are right are passed over.
//!
//! A queue has those that may be wrong, at first all. Whichever is first in it is looked at, and if
//! it is wrong it is solved exactly while the others' impulses stay; those whose velocities have
//! changed since they were looked at are looked at again. From a good guess most are never solved,
//! and what is wrong in one place costs nothing in others: so Southwell (1940) relaxed by hand,
//! with more care for the order.

mod delassus;
mod queue;
mod search;
mod settings;

use crate::{Body, Contact, ContactError, Report, Solver};
use delassus::check_finite;
use nalgebra::Vector3;
use search::ImpulseSearch;

pub(crate) use delassus::Delassus;
pub use settings::GaussSeidel;

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
        check_finite("component of a starting impulse", impulses)?;
        let delassus = Delassus::new(bodies, contacts, velocities)?;
        Ok(ImpulseSearch::new(self, delassus, contacts, impulses).run(impulses))
    }
}
