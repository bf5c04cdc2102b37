use crate::StepReport;
use crate::conditions::FiberConditions;
use nalgebra::Vector3;
use rapunzel_rod_dynamic::{Conditions, Energy, RodError, RodIntegrator, RodState, StepError};
use std::fmt::Debug;

/// Rods that are stepped together.
pub(crate) trait Batch: Send + Debug {
    fn state(&self, lane: usize) -> RodState;
    fn energy(&self, lane: usize, gravity: &Vector3<f64>) -> Energy;
    fn set_node_forces(&mut self, lane: usize, forces: &[Vector3<f64>]) -> Result<(), RodError>;
    fn step(&mut self, dt: f64, lanes: &[&dyn Conditions]) -> Result<StepReport, StepError>;
    fn save(&self, numbers: &mut Vec<f64>);
    fn restore(&mut self, numbers: &[f64]) -> Result<(), RodError>;
}

/// Rods that are stepped one after another.
impl<I: RodIntegrator + Debug> Batch for Vec<I> {
    fn state(&self, lane: usize) -> RodState {
        self[lane].state()
    }

    fn energy(&self, lane: usize, gravity: &Vector3<f64>) -> Energy {
        self[lane].energy(gravity)
    }

    fn set_node_forces(&mut self, lane: usize, forces: &[Vector3<f64>]) -> Result<(), RodError> {
        self[lane].set_node_forces(forces)
    }

    fn step(&mut self, dt: f64, lanes: &[&dyn Conditions]) -> Result<StepReport, StepError> {
        let mut sum = StepReport::default();
        for (lane, (rod, conditions)) in self.iter_mut().zip(lanes).enumerate() {
            let one = rod.step(dt, *conditions).map_err(|error| at_lane(error, lane))?;
            sum.add(&StepReport {
                fibers: 1,
                iterations: one.iterations,
                worst_iterations: one.iterations,
                halvings: one.halvings,
            });
        }
        Ok(sum)
    }

    /// Each rod's numbers after their count.
    fn save(&self, numbers: &mut Vec<f64>) {
        for rod in self {
            let at = numbers.len();
            numbers.push(0.0);
            rod.save(numbers);
            numbers[at] = (numbers.len() - at - 1) as f64;
        }
    }

    fn restore(&mut self, mut numbers: &[f64]) -> Result<(), RodError> {
        let found = numbers.len();
        for rod in self {
            let short = RodError::Length { what: "saved numbers", expected: found + 1, found };
            let (count, rest) = numbers.split_first().ok_or(short.clone())?;
            #[expect(clippy::cast_possible_truncation, reason = "a length written by save")]
            #[expect(clippy::cast_sign_loss, reason = "a length written by save")]
            let (own, rest) = rest.split_at_checked(*count as usize).ok_or(short)?;
            rod.restore(own)?;
            numbers = rest;
        }
        Ok(())
    }
}

/// An error of a rod by itself as one of a rod in a batch.
fn at_lane(mut error: StepError, lane: usize) -> StepError {
    if let StepError::NotConverged { fiber, .. } = &mut error {
        *fiber = lane;
    }
    error
}

/// A batch of fibres with what acts on them: the unit of parallel work.
#[derive(Debug)]
pub(crate) struct Group {
    /// Indices of the fibres, one per lane.
    pub(crate) fibers: Vec<usize>,
    pub(crate) batch: Box<dyn Batch>,
    pub(crate) lanes: Vec<FiberConditions>,
}

impl Group {
    /// Moves all fibres of the group from `time` by `dt`, s.
    pub(crate) fn step(&mut self, time: f64, dt: f64) -> Result<StepReport, StepError> {
        let middle = time + 0.5 * dt;
        for (lane, conditions) in self.lanes.iter().enumerate() {
            if let Some(forces) = conditions.node_forces(middle) {
                self.batch.set_node_forces(lane, &forces).map_err(|_| StepError::Conditions {
                    what: "node forces",
                    time,
                    why: "must be finite",
                })?;
            }
        }
        let during: Vec<_> = self.lanes.iter().map(|lane| lane.during(middle)).collect();
        let lanes: Vec<&dyn Conditions> = during.iter().map(|c| c as &dyn Conditions).collect();
        self.batch.step(dt, &lanes).map_err(|error| self.name_fiber(error))
    }

    /// Puts the index of the fibre in the scene in place of the lane.
    fn name_fiber(&self, mut error: StepError) -> StepError {
        if let StepError::NotConverged { fiber, .. } = &mut error {
            *fiber = self.fibers[*fiber];
        }
        error
    }
}
