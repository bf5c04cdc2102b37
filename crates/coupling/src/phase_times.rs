use std::ops::AddAssign;
use std::time::Duration;

/// What the phases of steps with contacts took by the
/// [stopwatch](crate::FibersInContact::set_stopwatch), zero without one. Measured, so never twice
/// the same: no file of a run has it.
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

/// Tells the time since some moment.
pub type Stopwatch = fn() -> Duration;

/// From phase to phase.
pub(crate) struct PhaseTimer {
    stopwatch: Option<Stopwatch>,
    last: Duration,
}

impl PhaseTimer {
    /// By a stopwatch, if there is one.
    pub(crate) fn start(stopwatch: Option<Stopwatch>) -> Self {
        Self { stopwatch, last: stopwatch.map_or(Duration::ZERO, |tell| tell()) }
    }

    /// Adds what has passed since the phase before.
    pub(crate) fn lap(&mut self, phase: &mut Duration) {
        let Some(tell) = self.stopwatch else { return };
        let now = tell();
        *phase += now.saturating_sub(self.last);
        self.last = now;
    }
}
