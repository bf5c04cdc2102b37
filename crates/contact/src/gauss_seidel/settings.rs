use crate::{ContactError, Tolerance};

/// Block Gauss-Seidel: one contact after the other is solved exactly while the others' impulses
/// stay, at first in the order of their first points (root to tip), until all obey the law.
///
/// It knows every answer explicitly and solves every limit curve exactly. An iteration is as many
/// solved contacts as there are. Where bodies have no [dense
/// operator](crate::Body::dense_delassus), memory and setup grow with the square of their touched
/// points; to solve a contact costs six columns: many contacts per fiber want
/// [`Solver`](crate::Solver)s that do without.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussSeidel {
    /// Tolerances at which it stops.
    pub tolerance: Tolerance,
    /// Part of the change to its exact solution that an impulse makes, more than zero and less than
    /// two; above one where many contacts support each other.
    pub relaxation: f64,
    /// Number of iterations after which it gives up if they leave no fewer contacts wrong than were
    /// before; [`usize::MAX`] for never. Contacts that hold each other may be solved round and
    /// round.
    pub patience: usize,
    /// Whether every contact is solved once, right or not, before those that are wrong: what few
    /// others hold is exact then, and not only as right as it must be.
    pub sweeps: bool,
}

impl GaussSeidel {
    /// The solver without relaxation, which does not give up before its last iteration.
    #[must_use]
    pub fn new(tolerance: Tolerance) -> Self {
        Self { tolerance, relaxation: 1.0, patience: usize::MAX, sweeps: false }
    }

    /// Checks tolerances and relaxation.
    ///
    /// # Errors
    /// [`ContactError::Invalid`] for a tolerance or relaxation out of range.
    pub(super) fn validate(&self) -> Result<(), ContactError> {
        let Tolerance { residual, normal, slip, .. } = self.tolerance;
        let checks = [
            ("tolerance of the residual", residual, f64::INFINITY),
            ("tolerance of normal velocities", normal, f64::INFINITY),
            ("tolerance of slip", slip, f64::INFINITY),
            ("relaxation", self.relaxation, 2.0_f64.next_down()),
        ];
        match checks.into_iter().find(|&(_, value, bound)| !(value > 0.0 && value <= bound)) {
            Some((what, value, _)) => Err(ContactError::Invalid {
                what,
                value,
                why: "it must be positive, a relaxation less than two",
            }),
            None => Ok(()),
        }
    }
}
