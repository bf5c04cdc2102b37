//! Globalisation of Newton's method in one lane: step lengths, the merit test, and when to stop.

use super::ends::Held;
use crate::RodStepReport;

/// Largest number of Newton iterations of one solve.
pub(super) const MAX_ITERATIONS: usize = 40;
/// Increments above this, rad, must lower the potential energy of the step. Smaller ones are not
/// tested: near the solution the test sees rounding only.
const MERIT_THRESHOLD: f64 = 0.03;
/// Largest rotation increment, rad: longer directions are scaled down to it.
const LARGEST_TURN: f64 = 3.0;
/// Error allowed after the last increment, rad.
const TOLERANCE: f64 = 1e-13;
/// Increments below this, rad, that hardly fall any more are rounding: some rods have modes that
/// cost nearly no energy, and the increments along them are noise.
const NOISE: f64 = 1e-5;
/// Increments below this, rad, are Newton's whatever the Hessian where loads have no potential:
/// nothing is minimised there, and with a part of the Hessian they fall only linearly.
const NEAR: f64 = 0.1;
/// Weights of the definite part that are tried in turn where the Hessian is indefinite: as little
/// as leads downhill, since with all of it saddles are left only slowly.
const DEFINITE_PARTS: [f64; 5] = [0.01, 0.03, 0.1, 0.3, 1.0];
/// Number of weights tried from which on a long increment is accepted.
const FIRM: usize = 4;
/// Largest number of halvings of a direction; then it is taken although the merit did not fall.
const MAX_HALVINGS: u8 = 12;

/// Outcome of Newton's method in one lane.
#[derive(Clone, Copy)]
pub(super) struct SearchOutcome {
    pub(super) converged: bool,
    pub(super) iterations: usize,
    /// Whether it ended where the Hessian of a conservative problem is not positive definite.
    pub(super) saddle: bool,
    /// Largest increment of each iteration, rad.
    pub(super) residuals: [f64; MAX_ITERATIONS],
}

impl SearchOutcome {
    pub(super) const NONE: Self =
        Self { converged: false, iterations: 0, saddle: false, residuals: [0.0; MAX_ITERATIONS] };

    pub(super) fn report(&self) -> RodStepReport {
        let residual = self.residuals[self.iterations.saturating_sub(1)];
        RodStepReport { iterations: self.iterations, halvings: 0, residual }
    }
}

/// Result of one linear solve in one lane.
pub(super) struct Solve {
    pub(super) iteration: usize,
    /// Largest rotation increment, rad.
    pub(super) turn: f64,
    /// Potential energy at the point of the solve, J.
    pub(super) energy: f64,
    /// Whether the gap of a held tip is closed to rounding.
    pub(super) closed: bool,
}

/// State of the line search in one lane.
#[derive(Clone, Copy)]
pub(super) struct Search {
    pub(super) active: bool,
    held: Held,
    /// Fraction of the present direction that is taken.
    length: f64,
    /// Energy at the origin of the direction, J, if the merit must fall.
    reference: Option<f64>,
    halvings: u8,
    /// Number of weights of the definite part tried in this solve.
    part: usize,
    /// Number of the weight to begin with should the Hessian be indefinite: one less than was
    /// needed last.
    likely: usize,
}

impl Search {
    pub(super) fn new(active: bool, held: Held, far: bool) -> Self {
        let likely = if far { DEFINITE_PARTS.len() } else { 0 };
        Self { active, held, length: 0.0, reference: None, halvings: 0, part: 0, likely }
    }

    /// Weight of the definite part in the next solve, 0 to 1.
    pub(super) fn definite_part(&self) -> f64 {
        if self.part == 0 { 0.0 } else { DEFINITE_PARTS[self.part - 1] }
    }

    /// Whether to solve once more with a larger weight of the definite part, after a solve whose
    /// Hessian was positive definite (`definite`) or not and whose largest increment is `turn`
    /// (rad).
    pub(super) fn needs_more(&mut self, definite: bool, turn: f64) -> bool {
        let sound = self.part == 0 || self.part >= FIRM || turn <= LARGEST_TURN;
        let near = self.part == 0 && !self.held.conservative && turn < NEAR;
        let usable = near || (definite && sound);
        let more = self.active && !usable && self.part < DEFINITE_PARTS.len();
        if more {
            self.part = (self.part + 1).max(self.likely);
        }
        more
    }

    /// Decides how to go on after a solve at the present point: `(fresh, scale)`, where `fresh` is
    /// 1 to follow the new direction and 0 to go back and take less of the old one.
    pub(super) fn next(&mut self, out: &mut SearchOutcome, solve: &Solve) -> (f64, f64) {
        let (iteration, turn) = (solve.iteration, solve.turn);
        out.iterations = iteration + 1;
        out.residuals[iteration] = turn;
        out.saddle = self.held.conservative && self.part > 0;
        if !turn.is_finite() {
            self.active = false;
            return (0.0, 0.0);
        }
        // The merit has not fallen: halve the step along the old direction.
        if let Some(reference) = self.reference
            && solve.energy > reference
            && self.halvings < MAX_HALVINGS
        {
            self.halvings += 1;
            self.length *= 0.5;
            self.part = 0;
            return (0.0, self.length);
        }
        // The point is accepted: follow the new direction, shortened to the largest turn.
        self.halvings = 0;
        self.length = (LARGEST_TURN / turn).min(1.0);
        let tested = turn > MERIT_THRESHOLD && self.held.minimizes();
        self.reference = tested.then_some(solve.energy + 1e-12 * solve.energy.abs());
        // Converged if the error expected after this increment is small, or increments are
        // rounding.
        let before = if iteration > 0 { out.residuals[iteration - 1] } else { f64::INFINITY };
        let expected = expected_error(turn, before, self.part == 0);
        let converged = expected < TOLERANCE || (turn < NOISE && turn > 0.9 * before);
        if converged && solve.closed {
            out.converged = true;
            self.active = false;
        }
        self.likely = self.part.saturating_sub(1);
        self.part = 0;
        (1.0, self.length)
    }
}

/// The error expected after an increment `turn` of Newton's method that followed an increment
/// `before`, infinite if none did, rad: quadratic convergence where the two show it and the Hessian
/// was exact, linear otherwise.
#[must_use]
pub fn expected_error(turn: f64, before: f64, exact: bool) -> f64 {
    let rate = turn / (before * before);
    if exact && rate < 30.0 {
        turn * turn * rate.max(1.0)
    } else if before.is_finite() {
        turn * turn / before
    } else {
        turn
    }
}
