//! Splitting first, then what is still wrong one by one.
//!
//! Splitting spreads impulses over all contacts at a time, but comes to its end slowly;
//! Gauss-Seidel ends soon, but only where errors are small or in few places, and each of its
//! answers leaves all contacts just below the tolerance, wrong together when the next problem is a
//! little different. A few iterations of the first make the second short, whose every solve begins
//! with contacts made even.

use crate::solver::respond;
use crate::{Admm, Body, Contact, ContactError, GaussSeidel, Report, Solver, Tolerance};
use nalgebra::Vector3;

/// Iterations of splitting before contacts are solved one by one.
const SPLITTING_ITERATIONS: usize = 20;
/// Relaxation of Gauss-Seidel: contacts of a bundle support each other.
const RELAXATION: f64 = 1.3;
/// Most iterations of Gauss-Seidel.
const GAUSS_SEIDEL_ITERATIONS: usize = 200;
/// Iterations of Gauss-Seidel in which it must come nearer.
const GAUSS_SEIDEL_PATIENCE: usize = 20;

/// [`Admm`] for some iterations, then [`GaussSeidel`] where that is not enough: a third of the
/// iterations that splitting alone takes to a tolerance of 1e-3 from a good guess.
///
/// Splitting alone solves what Gauss-Seidel does not come nearer to, such as fibers that jam each
/// other from all sides, and bodies that have no [dense operator](Body::dense_delassus).
#[derive(Debug, Clone)]
pub struct Polished {
    /// Tolerances at which it stops.
    pub tolerance: Tolerance,
    splitting: Admm,
    /// Whether solving one by one has led nowhere.
    stalled: bool,
}

impl Polished {
    /// A solver that stops at these tolerances.
    #[must_use]
    pub fn new(tolerance: Tolerance) -> Self {
        Self { tolerance, splitting: Admm::new(tolerance), stalled: false }
    }

    /// Forgets that solving one by one has led nowhere, since when only splitting is tried: what
    /// comes now is another problem.
    pub fn forget(&mut self) {
        self.stalled = false;
    }

    /// Splitting with at most this number of iterations.
    fn splitting(&mut self, iterations: usize) -> &mut Admm {
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
        let unpolished = self.stalled || SPLITTING_ITERATIONS >= most;
        if unpolished || bodies.iter().any(|body| body.dense_delassus().is_none()) {
            return self.splitting(most).solve(bodies, contacts, velocities, impulses);
        }
        // Some iterations of splitting even things out.
        let given = impulses.to_vec();
        let found =
            self.splitting(SPLITTING_ITERATIONS).solve(bodies, contacts, velocities, impulses)?;
        let mut spent = found.iterations;
        if found.converged || spent >= most {
            return Ok(found);
        }
        // Gauss-Seidel solves what is still wrong, from there.
        let changes: Vec<_> = impulses.iter().zip(&given).map(|(new, old)| new - old).collect();
        let velocities = respond(bodies, contacts, velocities, &changes);
        let split = impulses.to_vec();
        let iterations = GAUSS_SEIDEL_ITERATIONS.min(most - spent);
        let tolerance = Tolerance { iterations, ..self.tolerance };
        let (patience, relaxation) = (GAUSS_SEIDEL_PATIENCE, RELAXATION);
        let mut one_by_one = GaussSeidel { tolerance, patience, relaxation, sweeps: false };
        let found = one_by_one.solve(bodies, contacts, &velocities, impulses)?;
        spent += found.iterations;
        if found.converged || spent >= most {
            return Ok(Report { iterations: spent, ..found });
        }
        self.stalled = true;
        // Where that has led has few errors, but large ones.
        impulses.copy_from_slice(&split);
        let found = self.splitting(most - spent).solve(bodies, contacts, &velocities, impulses)?;
        Ok(Report { iterations: spent + found.iterations, ..found })
    }
}
