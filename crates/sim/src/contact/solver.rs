//! Which solver the contacts of a step get.

use crate::scene::ContactMethod;
use nalgebra::Vector3;
use rapunzel_contact::{Admm, Body, Contact, ContactError, GaussSeidel, Report, Solver, Tolerance};

/// Iterations after which contacts that are solved one by one are left to splitting.
const MOST: usize = 200;

/// The solver of a scene. Where its contacts are to be solved one by one, but bodies do not write out their
/// answers or that gets nowhere, splitting solves them.
pub(super) struct ContactSolver {
    pub(super) tolerance: Tolerance,
    method: ContactMethod,
    splitting: Admm,
}

impl ContactSolver {
    pub(super) fn new(method: ContactMethod) -> Self {
        let tolerance = Tolerance::EXACT;
        Self { tolerance, method, splitting: Admm::new(tolerance) }
    }
}

impl Solver for ContactSolver {
    fn solve(
        &mut self,
        bodies: &mut [&mut dyn Body],
        contacts: &[Contact],
        velocities: &[Vector3<f64>],
        impulses: &mut [Vector3<f64>],
    ) -> Result<Report, ContactError> {
        let Tolerance { iterations, .. } = self.tolerance;
        let mut spent = 0;
        if self.method == ContactMethod::OneByOne
            && bodies.iter().all(|body| body.written_out().is_some())
        {
            let tolerance = Tolerance { iterations: iterations.min(MOST), ..self.tolerance };
            let before = impulses.to_vec();
            let mut one_by_one = GaussSeidel::new(tolerance);
            let found = one_by_one.solve(bodies, contacts, velocities, impulses)?;
            if found.converged || found.iterations >= iterations {
                return Ok(found);
            }
            spent = found.iterations;
            // The velocities that are known are those with these.
            impulses.copy_from_slice(&before);
        }
        self.splitting.tolerance = Tolerance { iterations: iterations - spent, ..self.tolerance };
        let found = self.splitting.solve(bodies, contacts, velocities, impulses)?;
        Ok(Report { iterations: spent + found.iterations, ..found })
    }
}
