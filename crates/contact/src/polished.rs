//! Splitting first, then what is still wrong one by one.
//!
//! Splitting spreads impulses over all contacts at a time, but comes to its end slowly;
//! Gauss-Seidel ends soon, but only where errors are small or in few places, and each of its
//! answers leaves all contacts just below the tolerance, wrong together when the next problem is a
//! little different. A few iterations of the first make the second short, whose every solve begins
//! with contacts made even.

use crate::one_by_one::OneByOne;
use crate::solver::respond;
use crate::{Body, Contact, ContactError, Report, Solver, Tolerance};
use nalgebra::Vector3;

/// Iterations of splitting before contacts are solved one by one.
const SPLITTING_ITERATIONS: usize = 20;
/// Relaxation of Gauss-Seidel: contacts of a bundle support each other.
const RELAXATION: f64 = 1.3;
/// [`Admm`](crate::Admm) for some iterations, then [`GaussSeidel`](crate::GaussSeidel) where that
/// is not enough: a third of the iterations that splitting alone takes to a tolerance of 1e-3 from
/// a good guess.
///
/// Splitting alone solves what Gauss-Seidel does not come nearer to, such as fibers that jam each
/// other from all sides, and bodies that have no [dense operator](Body::dense_delassus).
#[derive(Debug, Clone)]
pub struct Polished {
    /// Tolerances at which it stops.
    pub tolerance: Tolerance,
    one_by_one: OneByOne,
}

impl Polished {
    /// A solver that stops at these tolerances.
    #[must_use]
    pub fn new(tolerance: Tolerance) -> Self {
        Self { tolerance, one_by_one: OneByOne::new(1.0, RELAXATION, false) }
    }

    /// Forgets that solving one by one has led nowhere, since when only splitting is tried: what
    /// comes now is another problem.
    pub fn forget(&mut self) {
        self.one_by_one.stalled = false;
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
        let Self { tolerance, one_by_one } = self;
        let most = tolerance.iterations;
        let unpolished = one_by_one.stalled || SPLITTING_ITERATIONS >= most;
        if unpolished || bodies.iter().any(|body| body.dense_delassus().is_none()) {
            let splitting = one_by_one.splitting(tolerance, most);
            return splitting.solve(bodies, contacts, velocities, impulses);
        }
        // Some iterations of splitting even things out.
        let given = impulses.to_vec();
        let splitting = one_by_one.splitting(tolerance, SPLITTING_ITERATIONS);
        let found = splitting.solve(bodies, contacts, velocities, impulses)?;
        if found.converged || found.iterations >= most {
            return Ok(found);
        }
        // Gauss-Seidel solves what is still wrong, from there.
        let changes: Vec<_> = impulses.iter().zip(&given).map(|(new, old)| new - old).collect();
        let velocities = respond(bodies, contacts, velocities, &changes);
        let rest = (&*tolerance, found.iterations);
        one_by_one.solve(rest, bodies, contacts, &velocities, impulses)
    }
}
