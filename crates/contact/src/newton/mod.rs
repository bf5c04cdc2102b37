//! Newton's method for few contacts, all of them at once.
//!
//! With `q = r - rho u`, `r` from the tip of the cone, the law is a system of equations that are
//! smooth in pieces (Alart and Curnier 1991):
//!
//! ```text
//! r_n = the larger of q_n and zero
//! r_t = the point nearest to q_t of the limit curve scaled by r_n
//! ```
//!
//! for any positive `rho`. Newton's method takes the derivatives of the pieces at hand (Qi and Sun
//! 1993). Once the pieces are the right ones it is at the end at once. Far from the answer it may
//! go round and round.

mod equations;

use crate::gauss_seidel::Delassus;
use crate::solver::check;
use crate::{Body, Contact, ContactError, FreeMasses, Report, Solver, Tolerance};
use equations::ContactEquations;
use nalgebra::Vector3;

/// Newton's method for the law of all contacts together.
///
/// An iteration solves a dense system of three equations for each contact that bears, and costs the
/// cube of their number; the matrix of answers is asked for once, three columns a point. Of use for
/// up to some dozens of contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SemismoothNewton {
    /// Tolerances at which it stops.
    pub tolerance: Tolerance,
}

impl Solver for SemismoothNewton {
    fn solve(
        &mut self,
        bodies: &mut [&mut dyn Body],
        contacts: &[Contact],
        velocities: &[Vector3<f64>],
        impulses: &mut [Vector3<f64>],
    ) -> Result<Report, ContactError> {
        check(bodies, contacts, velocities, impulses)?;
        let free = FreeMasses::new(bodies, contacts);
        let delassus = Delassus::new(bodies, contacts, velocities)?;
        let mut equations = ContactEquations::new(contacts, &delassus, &free, impulses);
        let reached = |found: &Report| self.tolerance.reached(found);
        let mut found = equations.report();
        let mut iterations = 0;
        // One iteration more than enough: near the answer it is right to many more digits.
        let mut polished = false;
        while iterations < self.tolerance.iterations && !(polished && reached(&found)) {
            polished = reached(&found);
            iterations += 1;
            if !equations.step() {
                break;
            }
            found = equations.report();
        }
        let converged = reached(&found);
        equations.write(impulses);
        Ok(Report { iterations, converged, ..found })
    }
}
