use std::ops::AddAssign;
use std::time::{Duration, Instant};

/// What the phases of steps with contacts took. Measured, so never twice the same: no file of a run has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ContactTimes {
    /// Lists of what touches, or may.
    pub detection: Duration,
    /// The laws of what is listed, and how well they hold.
    pub laws: Duration,
    /// The solver of all contacts, with how bodies answer.
    pub solver: Duration,
    /// Rods that are linearised and moved.
    pub rods: Duration,
}

impl ContactTimes {
    /// The sum.
    #[must_use]
    pub fn total(&self) -> Duration {
        self.detection + self.laws + self.solver + self.rods
    }
}

impl AddAssign for ContactTimes {
    fn add_assign(&mut self, other: Self) {
        self.detection += other.detection;
        self.laws += other.laws;
        self.solver += other.solver;
        self.rods += other.rods;
    }
}

/// Runs from phase to phase.
pub(super) struct Clock(Instant);

impl Clock {
    pub(super) fn start() -> Self {
        Self(Instant::now())
    }

    /// Adds what has passed since the phase before.
    pub(super) fn book(&mut self, phase: &mut Duration) {
        let before = std::mem::replace(&mut self.0, Instant::now());
        *phase += self.0 - before;
    }
}
