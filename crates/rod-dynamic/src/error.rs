#[cfg(feature = "modes")]
use rapunzel_linalg::LinalgError;
use thiserror::Error;

/// Errors of a rod, its state or its parameters.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RodError {
    /// An invalid argument.
    #[error("{what}: {why}")]
    Invalid {
        /// Name of the argument.
        what: &'static str,
        /// Description of the problem and of the allowed values.
        why: &'static str,
    },
    /// An array of the wrong length.
    #[error("{what} has {found} entries, but the rod needs {expected}")]
    Length {
        /// Name of the array.
        what: &'static str,
        /// Number of entries needed.
        expected: usize,
        /// Number of entries given.
        found: usize,
    },
    /// The eigenvalue problem of the small vibrations could not be solved.
    #[cfg(feature = "modes")]
    #[error("small motions: {0}")]
    Vibration(#[from] LinalgError),
}

/// Why a step could not be taken. The integrator is left as it was before the step.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum StepError {
    /// The step is not a positive, finite time.
    #[error("the time step is {0} s, but must be positive and finite")]
    TimeStep(f64),
    /// A condition is not finite, or its kind changed within the step.
    #[error("fibre {fiber}: {what} at t = {time} s: {why}")]
    Conditions {
        /// Index of the fibre in its batch, 0 for a single rod.
        fiber: usize,
        /// Name of the condition.
        what: &'static str,
        /// Time of the invalid condition, s.
        time: f64,
        /// Description of the problem and of the allowed values.
        why: &'static str,
    },
    /// Newton's method did not converge, however small the step.
    #[error(
        "fibre {fiber}: Newton's method did not converge at t = {time} s even with a step of \
         {dt} s; residuals [{}]. Use a smaller step, more segments, or more damping",
        brief(residuals)
    )]
    NotConverged {
        /// Index of the fibre in its batch, 0 for a single rod.
        fiber: usize,
        /// Start of the step that failed, s.
        time: f64,
        /// The smallest step tried, s.
        dt: f64,
        /// Relative residuals of the last attempt, one per iteration.
        residuals: Vec<f64>,
    },
}

/// Formats residuals with two digits each, separated by commas.
fn brief(numbers: &[f64]) -> String {
    numbers.iter().map(|x| format!("{x:.1e}")).collect::<Vec<_>>().join(", ")
}

impl StepError {
    /// The error with the fibre index `i` replaced by `index(i)`.
    #[must_use]
    pub fn renumbered(mut self, index: impl Fn(usize) -> usize) -> Self {
        match &mut self {
            Self::Conditions { fiber, .. } | Self::NotConverged { fiber, .. } => {
                *fiber = index(*fiber);
            }
            Self::TimeStep(_) => {}
        }
        self
    }
}
