//! Fibres that move on in another batch.

use super::batch::StaggeredBatch;
use crate::{Rod, RodError};

/// A fibre of a batch, with all numbers that determine its further motion.
#[derive(Debug, Clone)]
pub struct MovingRod {
    rod: Rod,
    numbers: Vec<f64>,
}

impl StaggeredBatch {
    /// The fibres of the batch between two steps.
    #[must_use]
    pub fn moving_rods(&self) -> Vec<MovingRod> {
        let one = |(fiber, rod): (usize, &Rod)| {
            let mut numbers = Vec::with_capacity(self.numbers_of(fiber));
            self.save_fiber(fiber, &mut numbers);
            MovingRod { rod: rod.clone(), numbers }
        };
        self.rods.iter().enumerate().map(one).collect()
    }

    /// Replaces the fibres by others of batches with the same method and time, and goes on with
    /// their motion as those would have. What is no part of a saved state is to be set again, as
    /// after [`Self::restore`]. Cost: that of a new batch.
    ///
    /// # Errors
    /// As [`StaggeredBatch::new`], and [`RodError::Length`] for the state of a fibre from a batch
    /// where some are damped, in one where none is, or the other way round. The fibres are then as
    /// before.
    pub fn replace_rods(&mut self, moving: Vec<MovingRod>) -> Result<(), RodError> {
        let (rods, states): (Vec<_>, Vec<_>) =
            moving.into_iter().map(|one| (one.rod, one.numbers)).unzip();
        let mut batch = Self::with_scheme(rods, self.scheme, self.flight)?;
        batch.time = self.time;
        batch.ledgers = self.ledgers.map(|_| Default::default());
        for (fiber, numbers) in states.iter().enumerate() {
            let (expected, found) = (batch.numbers_of(fiber), numbers.len());
            if found != expected {
                return Err(RodError::Length { what: "numbers of a fiber", expected, found });
            }
            batch.restore_fiber(fiber, numbers);
        }
        *self = batch;
        Ok(())
    }
}
