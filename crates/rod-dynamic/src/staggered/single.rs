use super::batch::StaggeredBatch;
use crate::{Conditions, Energy, Rod, RodError, RodIntegrator, RodState, RodStepReport, StepError};
use nalgebra::Vector3;

/// One fibre as a staggered chain: a [`StaggeredBatch`] of one.
pub struct Staggered(StaggeredBatch);

impl Staggered {
    /// A rod at rest in its natural shape at time 0, with the default `rho_inf`.
    ///
    /// # Errors
    /// As [`StaggeredBatch::new`].
    pub fn new(rod: Rod) -> Result<Self, RodError> {
        Self::with_rho_inf(rod, StaggeredBatch::DEFAULT_RHO_INF)
    }

    /// A rod at rest in its natural shape at time 0, with the spectral radius `rho_inf` at infinite
    /// frequency.
    ///
    /// # Errors
    /// As [`StaggeredBatch::new`].
    pub fn with_rho_inf(rod: Rod, rho_inf: f64) -> Result<Self, RodError> {
        StaggeredBatch::new(vec![rod], rho_inf).map(Self)
    }
}

impl RodIntegrator for Staggered {
    fn rod(&self) -> &Rod {
        &self.0.rods()[0]
    }
    fn time(&self) -> f64 {
        self.0.time()
    }
    fn state(&self) -> RodState {
        self.0.state(0)
    }
    fn set_state(&mut self, state: &RodState) -> Result<(), RodError> {
        self.0.set_state(0, state)
    }
    fn set_node_forces(&mut self, forces: &[Vector3<f64>]) -> Result<(), RodError> {
        self.0.set_node_forces(0, forces)
    }
    fn energy(&self, gravity: &Vector3<f64>) -> Energy {
        self.0.energy(0, gravity)
    }
    fn step(&mut self, dt: f64, conditions: &dyn Conditions) -> Result<RodStepReport, StepError> {
        let mut report = [RodStepReport::default()];
        self.0.step(dt, &[conditions], &mut report)?;
        Ok(report[0])
    }
    fn save(&self, numbers: &mut Vec<f64>) {
        self.0.save(numbers);
    }
    fn restore(&mut self, numbers: &[f64]) -> Result<(), RodError> {
        self.0.restore(numbers)
    }
}
