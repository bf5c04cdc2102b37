use crate::StepReport;
use crate::charging::Resting;
use crate::conditions::{BundleConditions, FiberConditions};
use nalgebra::Vector3;
use rapunzel_rod_dynamic::{
    self as rod, Conditions, Energy, Ledger, RodError, RodIntegrator, RodState, SectionLaws,
    StaggeredBatch, StepError, adaptive,
};
use std::sync::Arc;

/// Rods that are stepped together.
pub(crate) trait Batch: Send + Sync {
    fn state(&self, lane: usize) -> RodState;
    fn energy(&self, lane: usize, gravity: &Vector3<f64>) -> Energy;
    fn set_node_forces(&mut self, lane: usize, forces: &[Vector3<f64>]) -> Result<(), RodError>;
    fn step(&mut self, dt: f64, lanes: &[&dyn Conditions]) -> Result<StepReport, StepError>;
    /// The batch as one that can take a step in parts, if it is.
    fn coupled(&mut self) -> Option<&mut StaggeredBatch> {
        None
    }
    /// The same to be read.
    fn as_coupled(&self) -> Option<&StaggeredBatch> {
        None
    }
    /// The batch as one of fibres at rest, if it is.
    fn resting(&mut self) -> Option<&mut Resting> {
        None
    }
    /// The same to be read.
    fn as_resting(&self) -> Option<&Resting> {
        None
    }
    /// Keeps ledgers of the steps from now on, if it can.
    fn keep_ledgers(&mut self) {}
    /// That of the last step of a lane, if they are kept.
    fn ledger(&self, _lane: usize) -> Option<Ledger> {
        None
    }
    fn save(&self, numbers: &mut Vec<f64>);
    fn restore(&mut self, numbers: &[f64]) -> Result<(), RodError>;
}

/// Fibres in SIMD lanes.
impl Batch for StaggeredBatch {
    fn state(&self, lane: usize) -> RodState {
        self.state(lane)
    }

    fn energy(&self, lane: usize, gravity: &Vector3<f64>) -> Energy {
        self.energy(lane, gravity)
    }

    fn set_node_forces(&mut self, lane: usize, forces: &[Vector3<f64>]) -> Result<(), RodError> {
        self.set_node_forces(lane, forces)
    }

    fn step(&mut self, dt: f64, lanes: &[&dyn Conditions]) -> Result<StepReport, StepError> {
        let mut reports = [rod::StepReport::default(); Self::MAX_FIBERS];
        self.step(dt, lanes, &mut reports)?;
        Ok(sum(&reports[..lanes.len()]))
    }

    fn coupled(&mut self) -> Option<&mut StaggeredBatch> {
        Some(self)
    }

    fn as_coupled(&self) -> Option<&StaggeredBatch> {
        Some(self)
    }

    fn keep_ledgers(&mut self) {
        self.keep_ledgers(true);
    }

    fn ledger(&self, lane: usize) -> Option<Ledger> {
        self.ledger(lane)
    }

    fn save(&self, numbers: &mut Vec<f64>) {
        self.save(numbers);
    }

    fn restore(&mut self, numbers: &[f64]) -> Result<(), RodError> {
        self.restore(numbers)
    }
}

/// Rods that are stepped one after another.
pub(crate) struct Rods<I> {
    pub(crate) rods: Vec<I>,
    /// Error allowed in a second, m/s; `None` for steps as they are asked for.
    pub(crate) tolerance: Option<f64>,
}

impl<I: RodIntegrator> Rods<I> {
    fn step_one(
        &mut self,
        lane: usize,
        dt: f64,
        conditions: &dyn Conditions,
    ) -> Result<StepReport, StepError> {
        let rod = &mut self.rods[lane];
        match self.tolerance {
            None => {
                let one = rod.step(dt, conditions)?;
                Ok(StepReport::of_one(one.iterations, one.halvings, 0))
            }
            Some(tolerance) => {
                let one = adaptive::advance(rod, dt, tolerance * dt, conditions)?;
                Ok(StepReport::of_one(one.iterations, one.halvings, one.missed))
            }
        }
    }
}

impl<I: RodIntegrator + Sync> Batch for Rods<I> {
    fn state(&self, lane: usize) -> RodState {
        self.rods[lane].state()
    }

    fn energy(&self, lane: usize, gravity: &Vector3<f64>) -> Energy {
        self.rods[lane].energy(gravity)
    }

    fn set_node_forces(&mut self, lane: usize, forces: &[Vector3<f64>]) -> Result<(), RodError> {
        self.rods[lane].set_node_forces(forces)
    }

    fn step(&mut self, dt: f64, lanes: &[&dyn Conditions]) -> Result<StepReport, StepError> {
        let mut sum = StepReport::default();
        for (lane, conditions) in lanes.iter().enumerate() {
            let one = self.step_one(lane, dt, *conditions);
            sum.add(&one.map_err(|error| error.renumbered(|_| lane))?);
        }
        Ok(sum)
    }

    /// Each rod's numbers after their count.
    fn save(&self, numbers: &mut Vec<f64>) {
        for rod in &self.rods {
            let at = numbers.len();
            numbers.push(0.0);
            rod.save(numbers);
            numbers[at] = (numbers.len() - at - 1) as f64;
        }
    }

    fn restore(&mut self, mut numbers: &[f64]) -> Result<(), RodError> {
        let found = numbers.len();
        for rod in &mut self.rods {
            let short = RodError::Length { what: "saved numbers", expected: found + 1, found };
            let (count, rest) = numbers.split_first().ok_or(short.clone())?;
            #[expect(clippy::cast_possible_truncation, reason = "a length written by save")]
            let (own, rest) = rest.split_at_checked(*count as usize).ok_or(short)?;
            rod.restore(own)?;
            numbers = rest;
        }
        Ok(())
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
        let middle = self.load(time, dt)?;
        let during: Vec<_> = self.lanes.iter().map(|lane| lane.during(middle)).collect();
        let lanes: Vec<&dyn Conditions> = during.iter().map(|c| c as &dyn Conditions).collect();
        self.batch.step(dt, &lanes).map_err(|error| error.renumbered(|lane| self.fibers[lane]))
    }

    /// Sets out on the step from `time` by `dt`, s, with impulses (N s) on all nodes of all fibres
    /// at its start, without solving it.
    pub(crate) fn set_out(
        &mut self,
        time: f64,
        dt: f64,
        impulses: &[Vector3<f64>],
    ) -> Result<(), StepError> {
        let middle = self.load(time, dt)?;
        let during: Vec<_> = self.lanes.iter().map(|lane| lane.during(middle)).collect();
        let lanes: Vec<&dyn Conditions> = during.iter().map(|c| c as &dyn Conditions).collect();
        let mut reports = [rod::StepReport::default(); StaggeredBatch::MAX_FIBERS];
        let Some(batch) = self.batch.coupled() else { return Ok(()) };
        let done = batch.set_out(dt, &lanes, impulses, &mut reports);
        done.map_err(|error| error.renumbered(|lane| self.fibers[lane]))
    }

    /// Puts other impulses (N s) on all nodes in place of those before, without moving anything.
    pub(crate) fn press(&mut self, impulses: &[Vector3<f64>]) -> Result<(), StepError> {
        let Some(batch) = self.batch.coupled() else { return Ok(()) };
        batch.press(impulses).map_err(|error| error.renumbered(|lane| self.fibers[lane]))
    }

    /// Solves Newton's equations of the step; returns the largest increment, rad.
    pub(crate) fn linearize(&mut self) -> Result<f64, StepError> {
        let Some(batch) = self.batch.coupled() else { return Ok(0.0) };
        batch.linearize().map_err(|error| error.renumbered(|lane| self.fibers[lane]))
    }

    /// Takes the increments, with other impulses.
    pub(crate) fn advance(&mut self, impulses: &[Vector3<f64>]) -> Result<f64, StepError> {
        let Some(batch) = self.batch.coupled() else { return Ok(0.0) };
        batch.advance(impulses).map_err(|error| error.renumbered(|lane| self.fibers[lane]))
    }

    /// Gives sections the law of the climate at the end of the step from `time` by `dt`, s.
    fn follow_climate(&mut self, time: f64, dt: f64) -> Result<(), StepError> {
        let mut last: Option<(Arc<BundleConditions>, SectionLaws)> = None;
        for (lane, FiberConditions { bundle, .. }) in self.lanes.iter().enumerate() {
            let error = |why| StepError::Conditions {
                fiber: self.fibers[lane],
                what: "climate",
                time,
                why,
            };
            let laws = match &last {
                Some((of, laws)) if Arc::ptr_eq(of, bundle) => laws.clone(),
                _ => match bundle.laws(time + dt) {
                    None => continue,
                    Some(laws) => laws.map_err(|_| error("the law of hair is not known in it"))?,
                },
            };
            last = Some((Arc::clone(bundle), laws.clone()));
            if let Some(batch) = self.batch.coupled() {
                batch.set_laws(lane, laws).map_err(|_| error("laws must remember alike"))?;
            }
        }
        Ok(())
    }

    /// Sets the forces on nodes for the step from `time` by `dt`, s. Returns its middle.
    fn load(&mut self, time: f64, dt: f64) -> Result<f64, StepError> {
        let middle = time + 0.5 * dt;
        self.follow_climate(time, dt)?;
        self.put_forces(middle)?;
        Ok(middle)
    }

    /// Puts the forces of the scene at a time (s) on the nodes.
    pub(crate) fn put_forces(&mut self, time: f64) -> Result<(), StepError> {
        for (lane, conditions) in self.lanes.iter().enumerate() {
            if let Some(forces) = conditions.node_forces(time) {
                self.batch.set_node_forces(lane, &forces).map_err(|_| StepError::Conditions {
                    fiber: self.fibers[lane],
                    what: "node forces",
                    time,
                    why: "must be finite",
                })?;
            }
        }
        Ok(())
    }
}

/// What the steps of some fibres cost together.
fn sum(reports: &[rod::StepReport]) -> StepReport {
    let mut sum = StepReport::default();
    for one in reports {
        sum.add(&StepReport::of_one(one.iterations, one.halvings, 0));
    }
    sum
}
