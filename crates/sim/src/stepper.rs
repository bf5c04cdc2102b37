use crate::charging::ChargeReport;
use crate::contact::{ContactReport, ContactTimes};
use crate::{SimError, World};
use rapunzel_rod_dynamic::Ledger;
use rayon::prelude::*;

/// What a step of many fibres cost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepReport {
    /// Number of fibres.
    pub fibers: usize,
    /// Newton iterations, summed over the fibres.
    pub iterations: usize,
    /// Iterations of the fibre that needed most.
    pub worst_iterations: usize,
    /// How often the step of a fibre was halved because Newton's method failed.
    pub halvings: usize,
    /// How often a step was longer than its tolerance allows although it was the smallest.
    pub missed: usize,
    /// What the contacts were and cost, if there are any.
    pub contact: ContactReport,
    /// What their phases took.
    pub contact_times: ContactTimes,
    /// How charged fibres came to rest, if there are any.
    pub charge: ChargeReport,
}

impl StepReport {
    /// The report of a single fibre.
    pub(crate) fn of_one(iterations: usize, halvings: usize, missed: usize) -> Self {
        Self {
            fibers: 1,
            iterations,
            worst_iterations: iterations,
            halvings,
            missed,
            ..Self::default()
        }
    }

    /// Counts the fibres of another report too.
    pub(crate) fn add(&mut self, other: &Self) {
        self.fibers += other.fibers;
        self.iterations += other.iterations;
        self.worst_iterations = self.worst_iterations.max(other.worst_iterations);
        self.halvings += other.halvings;
        self.missed += other.missed;
        self.contact.add(&other.contact);
        self.contact_times += other.contact_times;
        self.charge.add(&other.charge);
    }
}

/// Moves a world in time.
pub trait Stepper {
    /// Moves all of `world` by `dt` seconds. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// [`SimError::Step`] names the fibre. After any error some fibres have been moved and others not,
    /// or all of them by a part of the step: [restore](World::restore) a snapshot before going on.
    fn step(&mut self, world: &mut World, dt: f64) -> Result<StepReport, SimError>;
}

/// Every fibre by itself: no contacts. Parallel over groups of fibres.
#[derive(Debug, Clone, Copy, Default)]
pub struct FreeFibers;

impl Stepper for FreeFibers {
    fn step(&mut self, world: &mut World, dt: f64) -> Result<StepReport, SimError> {
        let time = world.time();
        // The order of the results is that of the groups, whoever computes them; of several
        // errors the first fibre's is reported.
        let results: Vec<_> = world.groups.par_iter_mut().map(|g| g.step(time, dt)).collect();
        let mut report = StepReport::default();
        for result in results {
            report.add(&result.map_err(|source| SimError::Step { time, source })?);
        }
        world.book(&Ledger::default());
        world.advance_clock(dt);
        Ok(report)
    }
}
