//! Splitting first, then what is still wrong one by one.
//!
//! Splitting spreads impulses over all contacts at a time, but comes to its end slowly; Gauss-Seidel ends
//! soon, but only where errors are small or in few places, and each of its answers leaves all contacts just
//! below the tolerance, wrong together when the next problem is a little different. A few iterations of the
//! first make the second short, whose every solve begins with contacts made even.

use crate::solver::respond;
use crate::{Admm, Body, Contact, ContactError, GaussSeidel, Report, Solver, Tolerance};
use nalgebra::Vector3;

/// Iterations of Gauss-Seidel, at most, and those in which it must come nearer.
const MOST: usize = 200;
const PATIENCE: usize = 20;

/// [`Admm`] for some iterations, then [`GaussSeidel`] where that is not enough: a third of the iterations that
/// splitting alone takes to a tolerance of 1e-3 from a good guess.
///
/// Splitting alone solves what Gauss-Seidel does not come nearer to, such as fibers that jam each other from
/// all sides, and bodies that do not [write out](Body::written_out) their answers.
#[derive(Debug, Clone)]
pub struct Polished {
    /// When to stop.
    pub tolerance: Tolerance,
    /// Iterations of splitting before contacts are solved one by one; [`usize::MAX`] for never.
    pub splits: usize,
    splitting: Admm,
    /// Whether one by one has led nowhere.
    stalled: bool,
}

impl Polished {
    /// The solver with its usual number of splits.
    #[must_use]
    pub fn new(tolerance: Tolerance) -> Self {
        Self { tolerance, splits: 10, splitting: Admm::new(tolerance), stalled: false }
    }

    /// Forgets that solving one by one has led nowhere, since when only splitting is tried: what comes now
    /// is another problem.
    pub fn forget(&mut self) {
        self.stalled = false;
    }

    /// Splitting with so many iterations at most.
    fn split(&mut self, iterations: usize) -> &mut Admm {
        self.splitting.tolerance = Tolerance { iterations, ..self.tolerance };
        &mut self.splitting
    }
}

impl Solver for Polished {
    fn solve(
        &mut self,
        bodies: &mut [&mut dyn Body],
        contacts: &[Contact],
        velocities: &[Vector3<f64>],
        impulses: &mut [Vector3<f64>],
    ) -> Result<Report, ContactError> {
        let most = self.tolerance.iterations;
        let unpolished = self.stalled || self.splits >= most;
        if unpolished || bodies.iter().any(|body| body.written_out().is_none()) {
            return self.split(most).solve(bodies, contacts, velocities, impulses);
        }
        let given = impulses.to_vec();
        let found = self.split(self.splits).solve(bodies, contacts, velocities, impulses)?;
        let mut spent = found.iterations;
        if found.converged || spent >= most {
            return Ok(found);
        }
        let changes: Vec<_> = impulses.iter().zip(&given).map(|(new, old)| new - old).collect();
        let velocities = respond(bodies, contacts, velocities, &changes);
        let split = impulses.to_vec();
        let iterations = MOST.min(most - spent);
        let tolerance = Tolerance { iterations, ..self.tolerance };
        let mut one_by_one = GaussSeidel { patience: PATIENCE, ..GaussSeidel::new(tolerance) };
        let found = one_by_one.solve(bodies, contacts, &velocities, impulses)?;
        spent += found.iterations;
        if found.converged || spent >= most {
            return Ok(Report { iterations: spent, ..found });
        }
        self.stalled = true;
        // Where that has led has few errors, but large ones.
        impulses.copy_from_slice(&split);
        let found = self.split(most - spent).solve(bodies, contacts, &velocities, impulses)?;
        Ok(Report { iterations: spent + found.iterations, ..found })
    }
}
