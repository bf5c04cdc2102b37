//! Splitting, and Newton's method where contacts are few and it is slow.

use crate::solver::respond;
use crate::{Admm, Body, Contact, ContactError, Report, SemismoothNewton, Solver, Tolerance};
use nalgebra::Vector3;

/// Most contacts of which Newton's method is tried: its cost grows with the cube.
const FEW: usize = 32;
/// Iterations of splitting before that, in the first turn: nearly all problems are solved by then,
/// by impulses near those of the step before.
const FIRST: usize = 200;
/// Most iterations of Newton's method; half a dozen are usual where it comes to the end.
const NEWTON_ITERATIONS: usize = 12;
/// Largest change by Newton's method of all impulses together, relative to them.
const NEAR: f64 = 0.1;

/// [`Admm`], and [`SemismoothNewton`] from where it is after some iterations if there are only some
/// dozens of contacts. Where that does not come to the end, twice as many iterations lead to where
/// it begins again.
#[derive(Debug, Clone)]
pub struct Splitting {
    /// Tolerances at which it stops.
    pub tolerance: Tolerance,
    admm: Admm,
}

impl Splitting {
    /// A solver that stops at these tolerances.
    #[must_use]
    pub fn new(tolerance: Tolerance) -> Self {
        Self { tolerance, admm: Admm::new(tolerance) }
    }

    /// Splitting with at most this number of iterations.
    fn admm(&mut self, iterations: usize) -> &mut Admm {
        self.admm.tolerance = Tolerance { iterations, ..self.tolerance };
        &mut self.admm
    }
}

impl Solver for Splitting {
    fn solve(
        &mut self,
        bodies: &mut [&mut dyn Body],
        contacts: &[Contact],
        velocities: &[Vector3<f64>],
        impulses: &mut [Vector3<f64>],
    ) -> Result<Report, ContactError> {
        let most = self.tolerance.iterations;
        if contacts.len() > FEW {
            return self.admm(most).solve(bodies, contacts, velocities, impulses);
        }
        let (mut turn, mut spent) = (FIRST, 0);
        let (mut given, mut velocities) = (impulses.to_vec(), velocities.to_vec());
        loop {
            let left = most - spent;
            let found = self.admm(turn.min(left)).solve(bodies, contacts, &velocities, impulses)?;
            spent += found.iterations;
            if found.converged || spent >= most {
                return Ok(Report { iterations: spent, ..found });
            }
            let changes: Vec<_> = impulses.iter().zip(&given).map(|(new, old)| new - old).collect();
            velocities = respond(bodies, contacts, &velocities, &changes);
            given.copy_from_slice(impulses);
            let iterations = NEWTON_ITERATIONS.min(most - spent);
            let mut newton =
                SemismoothNewton { tolerance: Tolerance { iterations, ..self.tolerance } };
            let found = newton.solve(bodies, contacts, &velocities, impulses)?;
            spent += found.iterations;
            if found.converged && is_near(&given, impulses) {
                return Ok(Report { iterations: spent, ..found });
            }
            impulses.copy_from_slice(&given);
            turn *= 2;
        }
    }
}

/// Whether impulses have changed by little. What is jammed may be pressed together as hard as one
/// likes: an answer far away presses without need, and of that much a residual leaves too much.
fn is_near(from: &[Vector3<f64>], to: &[Vector3<f64>]) -> bool {
    let size: f64 = from.iter().map(Vector3::norm_squared).sum();
    let change: f64 = from.iter().zip(to).map(|(a, b)| (b - a).norm_squared()).sum();
    change <= NEAR * NEAR * size
}
