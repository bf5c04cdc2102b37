use super::elimination::{Elimination, Increment};
use super::stage::{StageEquations, Trial};

/// Full Newton steps are halved at most this often in the line search.
const BACKTRACKS: usize = 6;
/// Required share of the predicted decrease of the merit, thesis (3.172).
const ARMIJO: f64 = 1e-4;
/// Where rounding stops the descent, a residual of this many tolerances is good enough.
const NEWTON_ROUNDING: f64 = 1e3;

/// Newton's method with the exact Jacobian and a line search. Works in place, without allocation
/// once the residual history has grown.
#[derive(Debug, Clone)]
pub(super) struct Newton {
    /// The solution, or the last iterate.
    pub(super) trial: Trial,
    candidate: Trial,
    elimination: Elimination,
    /// Relative residuals, the start included.
    pub(super) history: Vec<f64>,
}

impl Newton {
    pub(super) fn new(segments: usize) -> Self {
        Self {
            trial: Trial::new(segments),
            candidate: Trial::new(segments),
            elimination: Elimination::new(segments),
            history: Vec::with_capacity(64),
        }
    }

    /// Solves `stage` from the unknowns in `self.trial`. Returns the linear systems solved, and
    /// whether the residual came below `tolerance`.
    ///
    /// The line search is Armijo's on the merit `phi = |F|^2`, whose slope along the Newton step
    /// is `-2 phi`: accept mu when `phi(mu) <= (1 - 2e-4 mu) phi(0)` ((3.172) after erratum).
    pub(super) fn solve(
        &mut self,
        stage: &StageEquations,
        tolerance: f64,
        max_iterations: usize,
    ) -> (usize, bool) {
        self.history.clear();
        stage.evaluate(&mut self.trial);
        for iteration in 0..=max_iterations {
            let residual = self.trial.merit.sqrt();
            self.history.push(residual);
            if residual <= tolerance {
                return (iteration, true);
            }
            if iteration == max_iterations || !residual.is_finite() {
                return (iteration, false);
            }
            if !self.advance(stage) {
                return (iteration + 1, residual <= NEWTON_ROUNDING * tolerance);
            }
        }
        (max_iterations, false)
    }

    /// One Newton step; false when no fraction of it decreases the merit.
    fn advance(&mut self, stage: &StageEquations) -> bool {
        let Self { trial, candidate, elimination, .. } = self;
        let increments = increments(stage, trial, elimination);
        // Line search: halve mu until the merit falls enough (3.172).
        let mut mu = 1.0;
        for _ in 0..=BACKTRACKS {
            for ((new, old), d) in candidate.x.iter_mut().zip(&trial.x).zip(increments) {
                *new = old.plus(mu, d);
            }
            stage.evaluate(candidate);
            if candidate.merit <= (1.0 - 2.0 * ARMIJO * mu) * trial.merit {
                std::mem::swap(trial, candidate);
                return true;
            }
            mu *= 0.5;
        }
        false
    }
}

/// The Newton increments at `trial`, which has been evaluated.
fn increments<'a>(
    stage: &StageEquations,
    trial: &Trial,
    elimination: &'a mut Elimination,
) -> &'a [Increment] {
    let [root, tip] = stage.end_rows(trial);
    let root_rotation = stage.root_rotation(&trial.x[0]);
    elimination.solve(&root, &root_rotation, &tip, |i, panel| stage.linearise(trial, i, panel))
}

#[cfg(test)]
impl Newton {
    /// The increments at `self.trial`, which has been evaluated.
    pub(super) fn increments(&mut self, stage: &StageEquations) -> Vec<Increment> {
        increments(stage, &self.trial, &mut self.elimination).to_vec()
    }
}
