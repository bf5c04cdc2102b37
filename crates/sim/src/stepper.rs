use crate::{SimError, World};
use rayon::prelude::*;

/// What a step of the whole world cost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepReport {
    /// Newton iterations, summed over the groups of fibres that are stepped together.
    pub iterations: usize,
    /// Number of groups.
    pub groups: usize,
    /// Iterations of the group that needed most.
    pub worst_iterations: usize,
    /// How often a group halved its step because Newton's method failed.
    pub halvings: usize,
}

/// Moves a world in time.
pub trait Stepper {
    /// Moves all of `world` by `dt` seconds. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// [`SimError::Step`] names the fibre. Some fibres have then been moved and others not:
    /// [restore](World::restore) a snapshot before going on.
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
            let group = result.map_err(|source| SimError::Step { time, source })?;
            report.groups += 1;
            report.iterations += group.iterations;
            report.worst_iterations = report.worst_iterations.max(group.iterations);
            report.halvings += group.halvings;
        }
        world.advance_clock(dt);
        Ok(report)
    }
}
