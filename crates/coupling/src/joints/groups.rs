//! The parts of a step of fibres that are joined.

use super::network::GroupMotion;
use crate::FiberGroup;
use nalgebra::Vector3;
use rapunzel_rod_dynamic::{
    Conditions, JointLoads, LoadPoint, RodError, RodStepReport, StaggeredBatch, StepError,
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

    /// Solves Newton's equations of the step, and tells where that leads the points, and, if asked
    /// for `responses`, how loads on them change it: else those of `motion` stay.
    pub(super) fn linearize_joined(
        &mut self,
        time: f64,
        points: &[LoadPoint],
        responses: bool,
        motion: &mut GroupMotion,
    ) -> Result<(), StepError> {
        self.linearize()?;
        let mut tell = || -> Result<(), RodError> {
            motion.ways.resize(points.len(), Vector3::zeros());
            self.batch.linear_ways(points, &mut motion.ways)?;
            if responses {
                motion.responses = self.batch.load_responses(points)?;
            }
            Ok(())
        };
        tell().map_err(|_| StepError::Conditions {
            fiber: self.fibers[0],
            what: "joints",
            time,
            why: "each must be between nodes of the fibres",
        })
    }

    /// Takes the increments, with other loads of joints.
    pub(super) fn advance_joined(&mut self, loads: JointLoads) -> Result<f64, StepError> {
        self.batch.advance_loaded(loads).map_err(|error| error.renumbered(|lane| self.fibers[lane]))
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
