//! The parts of a step of fibres that are joined.

use crate::FiberGroup;
use nalgebra::{DMatrix, Vector3};
use rapunzel_rod_dynamic::{
    Conditions, JointLoads, LoadPoint, RodStepReport, StaggeredBatch, StepError,
};

/// What a step is solved for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum JoinedSolve {
    /// The accelerations at the start of a motion.
    Start,
    /// The end of the step.
    End,
}

impl FiberGroup<StaggeredBatch> {
    /// Sets out on the step from `time` by `dt`, s, with these loads of joints.
    pub(super) fn set_out_joined(
        &mut self,
        (time, dt): (f64, f64),
        search: JoinedSolve,
        loads: JointLoads,
    ) -> Result<(), StepError> {
        let middle = self.load(time, dt)?;
        let during: Vec<_> = self.lanes.iter().map(|lane| lane.during(middle)).collect();
        let lanes: Vec<&dyn Conditions> = during.iter().map(|c| c as &dyn Conditions).collect();
        let done = match search {
            JoinedSolve::Start => self.batch.set_out_fresh(dt, &lanes, loads),
            JoinedSolve::End => {
                let reports = [RodStepReport::default(); StaggeredBatch::MAX_FIBERS];
                self.batch.set_out_loaded(dt, &lanes, loads, &reports)
            }
        };
        done.map_err(|error| error.renumbered(|lane| self.fibers[lane]))
    }

    /// Solves Newton's equations of the step, and tells where that leads the points. Returns the
    /// largest increment, rad.
    pub(super) fn linearize_joined(
        &mut self,
        time: f64,
        points: &[LoadPoint],
        ways: &mut [Vector3<f64>],
    ) -> Result<f64, StepError> {
        let turn = self.linearize()?;
        self.tell_ways(time, points, ways)?;
        Ok(turn)
    }

    /// Changes the loads of joints, and tells where that leads the points.
    pub(super) fn change_joined(
        &mut self,
        time: f64,
        changes: JointLoads,
        ways: &mut [Vector3<f64>],
    ) -> Result<(), StepError> {
        let done = self.batch.change_loads(changes);
        done.map_err(|error| error.renumbered(|lane| self.fibers[lane]))?;
        self.tell_ways(time, changes.points, ways)
    }

    /// By lane, the change of the ways of its points by loads on them.
    pub(super) fn responses(
        &mut self,
        time: f64,
        points: &[LoadPoint],
    ) -> Result<Vec<DMatrix<f64>>, StepError> {
        self.batch.load_responses(points).map_err(|_| self.off_fibers(time))
    }

    fn tell_ways(
        &self,
        time: f64,
        points: &[LoadPoint],
        ways: &mut [Vector3<f64>],
    ) -> Result<(), StepError> {
        self.batch.linear_ways(points, ways).map_err(|_| self.off_fibers(time))
    }

    fn off_fibers(&self, time: f64) -> StepError {
        let (fiber, why) = (self.fibers[0], "each must be between nodes of the fibres");
        StepError::Conditions { fiber, what: "joints", time, why }
    }

    /// Takes the increments. Returns the largest, rad.
    pub(super) fn take_joined(&mut self) -> Result<f64, StepError> {
        self.batch.take_increments().map_err(|error| error.renumbered(|lane| self.fibers[lane]))
    }

    /// Makes what has been solved the state.
    pub(super) fn accept_joined(
        &mut self,
        (time, dt): (f64, f64),
        search: JoinedSolve,
    ) -> Result<(), StepError> {
        match search {
            JoinedSolve::Start => {
                let middle = time + 0.5 * dt;
                let during: Vec<_> = self.lanes.iter().map(|lane| lane.during(middle)).collect();
                let lanes: Vec<&dyn Conditions> =
                    during.iter().map(|c| c as &dyn Conditions).collect();
                let done = self.batch.accept_start(&lanes);
                done.map_err(|error| error.renumbered(|lane| self.fibers[lane]))
            }
            JoinedSolve::End => {
                self.batch.accept();
                Ok(())
            }
        }
    }
}
