use crate::conditions::FiberConditions;
use nalgebra::Vector3;
use rapunzel_rod_dynamic::{
    Conditions, Energy, RodError, RodIntegrator, RodState, StepError, StepReport,
};

/// Rods that are stepped together.
pub(crate) trait Batch: Send {
    fn state(&self, lane: usize) -> RodState;
    fn energy(&self, lane: usize, gravity: &Vector3<f64>) -> Energy;
    fn set_node_forces(&mut self, lane: usize, forces: &[Vector3<f64>]) -> Result<(), RodError>;
    fn step(&mut self, dt: f64, lanes: &[&dyn Conditions]) -> Result<StepReport, StepError>;
    fn save(&self, numbers: &mut Vec<f64>);
    fn restore(&mut self, numbers: &[f64]) -> Result<(), RodError>;
}

/// One rod is a batch with a single lane.
impl<I: RodIntegrator> Batch for I {
    fn state(&self, _: usize) -> RodState {
        RodIntegrator::state(self)
    }

    fn energy(&self, _: usize, gravity: &Vector3<f64>) -> Energy {
        RodIntegrator::energy(self, gravity)
    }

    fn set_node_forces(&mut self, _: usize, forces: &[Vector3<f64>]) -> Result<(), RodError> {
        RodIntegrator::set_node_forces(self, forces)
    }

    fn step(&mut self, dt: f64, lanes: &[&dyn Conditions]) -> Result<StepReport, StepError> {
        RodIntegrator::step(self, dt, lanes[0])
    }

    fn save(&self, numbers: &mut Vec<f64>) {
        RodIntegrator::save(self, numbers);
    }

    fn restore(&mut self, numbers: &[f64]) -> Result<(), RodError> {
        RodIntegrator::restore(self, numbers)
    }
}

/// A batch of fibres with what acts on them: the unit of parallel work.
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
