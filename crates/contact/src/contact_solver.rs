use crate::{Adaptive, Body, Contact, ContactError, Polished, Report, Solver, Tolerance};
use nalgebra::Vector3;

/// A solver for many contacts, chosen at run time.
#[derive(Debug, Clone)]
pub enum ContactSolver {
    /// One by one where contacts are few, splitting where they are many.
    Adaptive(Adaptive),
    /// Splitting, then Gauss-Seidel where that is not enough.
    Polished(Polished),
}

impl ContactSolver {
    /// Tolerances at which the solver stops.
    #[must_use]
    pub fn tolerance(&self) -> &Tolerance {
        match self {
            Self::Adaptive(solver) => &solver.tolerance,
            Self::Polished(solver) => &solver.tolerance,
        }
    }

    /// Sets the tolerances at which the solver stops.
    pub fn set_tolerance(&mut self, tolerance: Tolerance) {
        match self {
            Self::Adaptive(solver) => solver.tolerance = tolerance,
            Self::Polished(solver) => solver.tolerance = tolerance,
        }
    }

    /// Forgets what has led nowhere, [`Adaptive::forget`] and [`Polished::forget`]: what comes now
    /// is another problem.
    pub fn forget(&mut self) {
        match self {
            Self::Adaptive(solver) => solver.forget(),
            Self::Polished(solver) => solver.forget(),
        }
    }

    /// Whether the last solve went one by one to its end, [`Adaptive::is_one_by_one`]: a more exact
    /// one costs hardly more.
    #[must_use]
    pub fn is_one_by_one(&self) -> bool {
        match self {
            Self::Adaptive(solver) => solver.is_one_by_one(),
            Self::Polished(_) => false,
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
            Self::Adaptive(solver) => solver.solve(bodies, contacts, velocities, impulses),
            Self::Polished(solver) => solver.solve(bodies, contacts, velocities, impulses),
        }
    }
}
