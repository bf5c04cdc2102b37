//! How well contacts are solved within Newton's method.

use rapunzel_contact::Tolerance;

/// The least and the largest of the errors, in tolerances, that solves of contacts leave.
const TIGHT: f64 = 0.9;
const LOOSE: f64 = 15.0;
/// Error that the first solve of a step leaves, in tolerances.
const FIRST: f64 = 40.0;
/// The largest where contacts are polished: then most of them have errors as large as they may be.
const POLISHED: f64 = 3.0;
/// Iterations, at most, of a solve that is not the last.
const MOST_ROUGH_ITERATIONS: usize = 120;
/// How much deeper than they may be fibres are left by a list that is not solved exactly the next
/// time either, and what that leaves of it, in tolerances.
const OFF: f64 = 2.0;
const PART: f64 = 3.0;
/// What Newton's method makes of an error, by its square: as found where hair falls and swings.
const SQUARE: f64 = 1e-4;

/// The forcing term of an inexact Newton method: the error that a solve of the contacts may leave,
/// in tolerances, and its iterations at most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ForcingTerm {
    slack: f64,
    most: usize,
}

impl ForcingTerm {
    /// Forcing term of the first solve of a step: as long as the rods are far from where they go,
    /// exact answers are wasted.
    const FIRST: Self = Self { slack: FIRST, most: MOST_ROUGH_ITERATIONS / 2 };
    /// Forcing term of the last solve of a step.
    pub(super) const LAST: Self = Self { slack: TIGHT, most: usize::MAX };

    /// From where a step is expected to lead, which leaves an `error`, in tolerances.
    pub(super) fn first(error: f64) -> Self {
        let next = Self::after(error);
        if next.is_last() { next } else { Self::FIRST }
    }

    /// After an iteration that left an `error`, in tolerances: the next leaves its square times a
    /// constant, however well it is solved.
    pub(super) fn after(error: f64) -> Self {
        let slack = SQUARE * error * error;
        if slack > TIGHT {
            Self { slack: slack.min(LOOSE), most: MOST_ROUGH_ITERATIONS }
        } else {
            Self::LAST
        }
    }

    /// With contacts that are new where fibres were left so many times deeper in each other than
    /// they may be. Where hardly any are, loose answers lead away.
    pub(super) fn where_off(times: f64) -> Self {
        if times > OFF {
            Self { slack: LOOSE.min(PART * times), most: MOST_ROUGH_ITERATIONS }
        } else {
            Self::LAST
        }
    }

    /// After a solve that did not come so far: one that need not, with so many times its
    /// iterations.
    pub(super) fn again(self, times: usize) -> Self {
        Self { slack: self.slack.max(LOOSE), most: self.most.saturating_mul(times) }
    }

    /// One that leaves what is of use where contacts are polished.
    pub(super) fn polished(self) -> Self {
        Self { slack: self.slack.min(POLISHED), ..self }
    }

    pub(super) fn is_last(self) -> bool {
        self == Self::LAST
    }

    /// The tolerance that a solver gets.
    pub(super) fn of(self, tolerance: &Tolerance) -> Tolerance {
        Tolerance {
            residual: self.slack * tolerance.residual,
            normal: self.slack * tolerance.normal,
            slip: self.slack * tolerance.slip,
            iterations: self.most.min(tolerance.iterations),
        }
    }
}
