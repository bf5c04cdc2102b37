//! Gauss-Seidel for as long as it comes nearer, and splitting where it does not.

use crate::{Admm, Body, Contact, ContactError, GaussSeidel, Report, Solver, Tolerance};
use nalgebra::Vector3;

/// Most iterations of Gauss-Seidel.
const GAUSS_SEIDEL_ITERATIONS: usize = 200;
/// Iterations of Gauss-Seidel in which it must come nearer.
const GAUSS_SEIDEL_PATIENCE: usize = 20;

/// [`GaussSeidel`], and [`Admm`] from where that began once it has led nowhere.
#[derive(Debug, Clone)]
pub(crate) struct OneByOne {
    splitting: Admm,
    /// Part of the tolerances that contacts are solved to one by one: each leaves as much as it
    /// may.
    pub(crate) part: f64,
    /// Relaxation of Gauss-Seidel.
    pub(crate) relaxation: f64,
    /// Whether all contacts are solved once, [`GaussSeidel::sweeps`].
    pub(crate) sweeps: bool,
    /// Whether solving one by one has led nowhere, since when only splitting is tried.
    pub(crate) stalled: bool,
}

impl OneByOne {
    /// Gauss-Seidel to a part of the tolerances, with a relaxation, that sweeps first or not.
    pub(crate) fn new(part: f64, relaxation: f64, sweeps: bool) -> Self {
        let splitting = Admm::new(Tolerance::EXACT);
        Self { splitting, part, relaxation, sweeps, stalled: false }
    }

    /// Splitting alone, with at most so many iterations.
    pub(crate) fn splitting(&mut self, tolerance: &Tolerance, iterations: usize) -> &mut Admm {
        self.splitting.tolerance = Tolerance { iterations, ..*tolerance };
        &mut self.splitting
    }

    /// As [`Solver::solve`], after so many iterations were `spent`: the report counts these too.
    pub(crate) fn solve(
        &mut self,
        (tolerance, spent): (&Tolerance, usize),
        bodies: &mut [&mut dyn Body],
        contacts: &[Contact],
        velocities: &[Vector3<f64>],
        impulses: &mut [Vector3<f64>],
    ) -> Result<Report, ContactError> {
        let left = tolerance.iterations - spent;
        let given = impulses.to_vec();
        let mut one_by_one = GaussSeidel {
            tolerance: Tolerance {
                residual: self.part * tolerance.residual,
                normal: self.part * tolerance.normal,
                slip: self.part * tolerance.slip,
                iterations: GAUSS_SEIDEL_ITERATIONS.min(left),
            },
            patience: GAUSS_SEIDEL_PATIENCE,
            relaxation: self.relaxation,
            sweeps: self.sweeps,
        };
        let found = one_by_one.solve(bodies, contacts, velocities, impulses)?;
        let converged = tolerance.reached(&found);
        let iterations = spent + found.iterations;
        if converged || found.iterations >= left {
            return Ok(Report { iterations, converged, ..found });
        }
        self.stalled = true;
        // Where that has led has few errors, but large ones.
        impulses.copy_from_slice(&given);
        let splitting = self.splitting(tolerance, left - found.iterations);
        let found = splitting.solve(bodies, contacts, velocities, impulses)?;
        Ok(Report { iterations: iterations + found.iterations, ..found })
    }
}
