use crate::{Admm, Body, Contact, ContactError, Polished, Report, Solver, Tolerance};
use nalgebra::Vector3;

/// A solver for many contacts, chosen at run time.
#[derive(Debug, Clone)]
pub enum ContactSolver {
    /// Splitting alone.
    Splitting(Admm),
    /// Splitting, then Gauss-Seidel where that is not enough.
    Polished(Polished),
}

impl ContactSolver {
    /// Tolerances at which the solver stops.
    #[must_use]
    pub fn tolerance(&self) -> &Tolerance {
        match self {
            Self::Splitting(solver) => &solver.tolerance,
            Self::Polished(solver) => &solver.tolerance,
        }
    }

    /// Sets the tolerances at which the solver stops.
    pub fn set_tolerance(&mut self, tolerance: Tolerance) {
        match self {
            Self::Splitting(solver) => solver.tolerance = tolerance,
            Self::Polished(solver) => solver.tolerance = tolerance,
        }
    }

    /// Forgets what has led nowhere, [`Polished::forget`]: what comes now is another problem.
    pub fn forget(&mut self) {
        if let Self::Polished(solver) = self {
            solver.forget();
        }
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
        match self {
            Self::Splitting(solver) => solver.solve(bodies, contacts, velocities, impulses),
            Self::Polished(solver) => solver.solve(bodies, contacts, velocities, impulses),
        }
    }
}
