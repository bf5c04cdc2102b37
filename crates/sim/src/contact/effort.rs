//! How well contacts are solved within Newton's method.

use rapunzel_contact::Tolerance;

/// The least and the largest of the errors, in tolerances, that solves of contacts leave.
const TIGHT: f64 = 0.8;
const LOOSE: f64 = 15.0;
/// The same of a first guess.
const GUESS: f64 = 40.0;
/// A first guess that leaves a smaller error than this, in tolerances, needs no other.
pub(super) const FAIR: f64 = 60.0;
/// Where a guess leaves a larger error, in tolerances, lists will change, and are first solved to a
/// coarser one.
pub(super) const ROUGH: f64 = 350.0;
pub(super) const COARSE: f64 = 5.0;
/// What Newton's method makes of an error, by its square: as found where hair falls and swings.
const SQUARE: f64 = 1e-5;

/// The error that a solve may leave, in tolerances, and its iterations at most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Effort {
    slack: f64,
    most: usize,
}

impl Effort {
    /// As long as the rods are far from where they go, exact answers are wasted.
    pub(super) const FIRST: Self = Self { slack: GUESS, most: 60 };
    /// What is asked for in the end.
    pub(super) const LAST: Self = Self { slack: TIGHT, most: usize::MAX };

    /// After an iteration that left an `error`, in tolerances: the next leaves its square times a
    /// constant, however well it is solved.
    pub(super) fn after(error: f64) -> Self {
        let slack = SQUARE * error * error;
        if slack > TIGHT { Self { slack: slack.min(LOOSE), most: 120 } } else { Self::LAST }
    }

    /// The same where `goal` times the tolerances will do.
    pub(super) fn toward(self, goal: f64) -> Self {
        Self { slack: self.slack.max(TIGHT * goal), ..self }
    }

    /// The same with more iterations.
    pub(super) fn longer(self, times: usize) -> Self {
        Self { most: self.most.saturating_mul(times), ..self }
    }

    /// What it asks of a solver.
    pub(super) fn of(self, tolerance: &Tolerance) -> Tolerance {
        Tolerance {
            residual: self.slack * tolerance.residual,
            normal: self.slack * tolerance.normal,
            slip: self.slack * tolerance.slip,
            iterations: self.most.min(tolerance.iterations),
        }
    }
}
