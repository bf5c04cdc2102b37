//! One by one where contacts are few, splitting where they are many.

use crate::{Admm, Body, Contact, ContactError, GaussSeidel, Report, Solver, Tolerance};
use nalgebra::{Matrix3, Vector3};

/// Sides of contacts, on the average of what moves, up to which contacts are few.
const FEW: usize = 4;
/// Part of the tolerances that contacts are solved to one by one: each leaves as much as it may.
const PART: f64 = 0.1;
/// Part of its whole answer to impulses by which a stiff contact answers one along its normal, as
/// that of a straight fibre with its end on a plane: the impulse that solves it alone is so large
/// that the fibre buckles.
const STIFF: f64 = 1e-3;
/// Most iterations of Gauss-Seidel.
const GAUSS_SEIDEL_ITERATIONS: usize = 200;
/// Iterations of Gauss-Seidel in which it must come nearer.
const GAUSS_SEIDEL_PATIENCE: usize = 20;

/// [`GaussSeidel`] where what moves has few contacts each, as hair that falls and hangs, and
/// [`Admm`] where it has many, where bodies have no [dense operator](Body::dense_delassus) or
/// hardly answer along a normal, and where the first does not come to an end.
///
/// Few contacts make many small problems that know nothing of each other. Gauss-Seidel ends each
/// when it is solved; every iteration of splitting is one of all, until the last is solved.
#[derive(Debug, Clone)]
pub struct Adaptive {
    /// Tolerances at which it stops.
    pub tolerance: Tolerance,
    splitting: Admm,
    /// Whether solving one by one has led nowhere.
    stalled: bool,
}

impl Adaptive {
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
}

impl Solver for Adaptive {
    fn solve(
        &mut self,
        bodies: &mut [&mut dyn Body],
        contacts: &[Contact],
        velocities: &[Vector3<f64>],
        impulses: &mut [Vector3<f64>],
    ) -> Result<Report, ContactError> {
        let Tolerance { residual, normal, slip, iterations: most } = self.tolerance;
        let mut spent = 0;
        if !self.stalled && are_few(bodies, contacts) {
            let tolerance = Tolerance {
                residual: PART * residual,
                normal: PART * normal,
                slip: PART * slip,
                iterations: GAUSS_SEIDEL_ITERATIONS.min(most),
            };
            let (patience, relaxation) = (GAUSS_SEIDEL_PATIENCE, 1.0);
            let mut one_by_one = GaussSeidel { tolerance, patience, relaxation, sweeps: true };
            let given = impulses.to_vec();
            let found = one_by_one.solve(bodies, contacts, velocities, impulses)?;
            let converged = self.tolerance.reached(&found);
            if converged || found.iterations >= most {
                return Ok(Report { converged, ..found });
            }
            // Where that has led has few errors, but large ones.
            impulses.copy_from_slice(&given);
            (spent, self.stalled) = (found.iterations, true);
        }
        self.splitting.tolerance = Tolerance { iterations: most - spent, ..self.tolerance };
        let found = self.splitting.solve(bodies, contacts, velocities, impulses)?;
        Ok(Report { iterations: spent + found.iterations, ..found })
    }
}

/// Whether all that moves has a dense operator at hand, and few contacts, none of which is stiff.
fn are_few(bodies: &[&mut dyn Body], contacts: &[Contact]) -> bool {
    let (mut own, mut moving) = (Vec::new(), 0);
    for body in bodies {
        let Some(groups) = body.dense_delassus() else { return false };
        let start = own.len();
        own.resize(start + body.points(), Matrix3::zeros());
        for (points, blocks) in &groups {
            points.iter().enumerate().for_each(|(i, &k)| own[start + k] = blocks.block(i, i));
        }
        moving += groups.len();
    }
    let sides = contacts.iter().map(|contact| 1 + usize::from(contact.second.is_some()));
    let is_stiff = |contact: &Contact| {
        let answer = |point: usize| own.get(point).copied().unwrap_or_default();
        let answer = answer(contact.first) + contact.second.map_or_else(Matrix3::zeros, answer);
        let normal = contact.frame.column(0);
        normal.dot(&(answer * normal)) < STIFF * answer.trace()
    };
    sides.sum::<usize>() <= FEW * moving && !contacts.iter().any(is_stiff)
}
