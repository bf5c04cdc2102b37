//! Globalisation of Newton's method in one lane: step lengths, the merit test, and when to stop.

use super::ends::Held;
use crate::RodStepReport;

/// Largest number of Newton iterations of one solve.
pub(super) const MAX_ITERATIONS: usize = 40;
/// Increments above this, rad, must lower the potential energy of the step. Smaller ones are not
/// tested: near the solution the test sees rounding only.
const MERIT_THRESHOLD: f64 = 0.03;
/// A direction is shortened until its largest increment is this, rad.
const LARGEST_TURN: f64 = 3.0;
/// The error that may be left after the last increment, rad.
const TOLERANCE: f64 = 1e-13;
/// Increments below this, rad, that hardly fall any more are rounding: some rods have modes that
/// cost nearly no energy, and the increments along them are noise.
const NOISE: f64 = 1e-5;
/// How much of the definite part is tried in turn where the Hessian is indefinite: as little as
/// leads downhill, since with all of it saddles are left only slowly.
const DEFINITE_PARTS: [f64; 5] = [0.01, 0.03, 0.1, 0.3, 1.0];
/// From this part on a long increment is taken as it is.
const FIRM: usize = 4;
/// How often a direction is halved before it is taken as it is.
const MAX_HALVINGS: u8 = 12;

/// How Newton's method went.
#[derive(Clone, Copy)]
pub(super) struct SearchOutcome {
    pub(super) converged: bool,
    pub(super) iterations: usize,
    /// Whether it ended where the Hessian is not positive definite.
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

/// What one solve tells about one lane.
pub(super) struct Solve {
    pub(super) iteration: usize,
    /// Largest increment, rad.
    pub(super) turn: f64,
    /// Potential energy where the solve was made.
    pub(super) energy: f64,
    /// Whether a held tip is where it should be.
    pub(super) closed: bool,
}

/// State of the search in one lane.
#[derive(Clone, Copy)]
pub(super) struct Search {
    pub(super) active: bool,
    held: Held,
    /// Length of the present direction, and the energy at its origin if it must fall.
    length: f64,
    reference: Option<f64>,
    halvings: u8,
    /// How many of the definite parts have been tried in this solve, and where to begin should the
    /// Hessian be indefinite: one less than was needed last.
    part: usize,
    likely: usize,
}

impl Search {
    pub(super) fn new(active: bool, held: Held, far: bool) -> Self {
        let likely = if far { DEFINITE_PARTS.len() } else { 0 };
        Self { active, held, length: 0.0, reference: None, halvings: 0, part: 0, likely }
    }

    /// How much of the definite part the next solve uses.
    pub(super) fn definite_part(&self) -> f64 {
        if self.part == 0 { 0.0 } else { DEFINITE_PARTS[self.part - 1] }
    }

    /// Whether to solve once more with more of the definite part, after a solve whose matrix was
    /// `definite` or not and whose largest increment is `turn`.
    pub(super) fn needs_more(&mut self, definite: bool, turn: f64) -> bool {
        let sound = self.part == 0 || self.part >= FIRM || turn <= LARGEST_TURN;
        let more = self.active && !(definite && sound) && self.part < DEFINITE_PARTS.len();
        if more {
            self.part = (self.part + 1).max(self.likely);
        }
        more
    }

    /// Decides what follows from a solve at the present point: `(fresh, scale)`, where `fresh` is
    /// 1 to set out along the new direction and 0 to go back and try less of the old one.
    pub(super) fn next(&mut self, out: &mut SearchOutcome, solve: &Solve) -> (f64, f64) {
        let (iteration, turn) = (solve.iteration, solve.turn);
        out.iterations = iteration + 1;
        out.residuals[iteration] = turn;
        out.saddle = self.held.conservative && self.part > 0;
        if !turn.is_finite() {
            self.active = false;
            return (0.0, 0.0);
        }
        if let Some(reference) = self.reference
            && solve.energy > reference
            && self.halvings < MAX_HALVINGS
        {
            self.halvings += 1;
            self.length *= 0.5;
            self.part = 0;
            return (0.0, self.length);
        }
        self.halvings = 0;
        self.length = (LARGEST_TURN / turn).min(1.0);
        let tested = turn > MERIT_THRESHOLD && self.held.minimizes();
        self.reference = tested.then_some(solve.energy + 1e-12 * solve.energy.abs());
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

/// The error expected after an increment `turn` that followed an increment `before`: quadratic
/// convergence where the two show it and the Hessian was exact, linear otherwise.
fn expected_error(turn: f64, before: f64, exact: bool) -> f64 {
    let rate = turn / (before * before);
    if exact && rate < 30.0 {
        turn * turn * rate.max(1.0)
    } else if before.is_finite() {
        turn * turn / before
    } else {
        turn
    }
}
