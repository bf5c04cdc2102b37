//! Steps of fibres that are joined to others, in Newton iterations of all together.

use super::batch::StaggeredBatch;
use super::batch_step::sets_out_smoothly;
use super::coupled::check;
use super::scheme::StepProblem;
use crate::{Conditions, JointLoads, LoadPlace, LoadPoint, RodError, RodStepReport, StepError};
use nalgebra::{DMatrix, UnitQuaternion, Vector3};
use rapunzel_lanes::LANES;

impl StaggeredBatch {
    /// Starts a step of `dt` seconds with these loads of joints, at the predicted shape, without
    /// solving it: [`Self::linearize`], [`Self::change_loads`] and [`Self::take_increments`] do
    /// that, one Newton iteration after another, until [`Self::accept`] or [`Self::abandon`]. Such
    /// a step is not halved, since fibres that are joined must take the same step. The fibres must
    /// not be [fresh](Self::is_fresh). The batch holds its workspace from now on.
    ///
    /// # Errors
    /// [`StepError`] for conditions and loads that make no sense; the fibres are then as before.
    ///
    /// # Panics
    /// If there are fewer conditions or reports than fibres.
    pub fn set_out_loaded(
        &mut self,
        dt: f64,
        conditions: &[&dyn Conditions],
        loads: JointLoads,
        reports: &[RodStepReport],
    ) -> Result<(), StepError> {
        self.check_loads(loads)?;
        self.fresh_before = self.fresh;
        self.engine.keep();
        self.engine.hold_workspace(true);
        self.engine.set_problem(StepProblem::Step);
        self.working(|batch| {
            batch.begin(dt, conditions, reports)?;
            batch.engine.set_joint_loads(loads);
            batch.engine.look(dt);
            batch.under_way(dt, Ok(()))
        })
    }

    /// Whether the initial acceleration of a fibre is still to be found, by [`Self::set_out_fresh`]
    /// where fibres are joined: its state has just been set, and its method needs one.
    #[must_use]
    pub fn is_fresh(&self) -> bool {
        (0..self.rods.len()).any(|fiber| self.fresh[fiber] && self.engine.remembers(fiber))
    }

    /// Sets out on the search for the accelerations at the start, as [`Self::set_out_loaded`] on a
    /// step; to be ended by [`Self::accept_start`] or [`Self::abandon`].
    ///
    /// # Errors
    /// As [`Self::set_out_loaded`].
    ///
    /// # Panics
    /// As [`Self::set_out_loaded`].
    pub fn set_out_fresh(
        &mut self,
        dt: f64,
        conditions: &[&dyn Conditions],
        loads: JointLoads,
    ) -> Result<(), StepError> {
        self.check_loads(loads)?;
        if !(dt > 0.0 && dt.is_finite()) {
            return Err(StepError::TimeStep(dt));
        }
        let count = self.rods.len();
        assert!(conditions.len() >= count, "one for each fibre");
        let at = |time: f64| -> Result<Vec<_>, StepError> {
            (0..count).map(|fiber| self.conditions(fiber, time, conditions[fiber])).collect()
        };
        let (start, end) = (at(self.time)?, at(self.time + dt)?);
        self.fresh_before = self.fresh;
        self.engine.keep();
        self.engine.hold_workspace(true);
        self.engine.set_problem(StepProblem::Start);
        self.working(|batch| {
            batch.engine.remember();
            batch.engine.set_out(&[true; LANES]);
            for fiber in (0..count).filter(|&fiber| batch.fresh[fiber]) {
                batch.engine.set_conditions(fiber, &start[fiber]);
            }
            batch.engine.measure(&batch.fresh);
            end.iter().enumerate().for_each(|(fiber, now)| batch.engine.set_conditions(fiber, now));
            batch.engine.set_joint_loads(loads);
            batch.engine.look(dt);
            batch.under_way(dt, Ok(()))
        })
    }

    /// Takes the accelerations that have been found as those at the start, where there are any: not
    /// of fibres whose roots are jerked. Time stays.
    ///
    /// # Errors
    /// [`StepError::Conditions`] for conditions that make no sense.
    pub fn accept_start(&mut self, conditions: &[&dyn Conditions]) -> Result<(), StepError> {
        self.check_under_way()?;
        let dt = std::mem::take(&mut self.predicted);
        let mut done = [false; LANES];
        for fiber in 0..self.rods.len() {
            let at = |steps: f64| self.conditions(fiber, self.time + steps * dt, conditions[fiber]);
            let (now, then) = (at(1.0)?, at(2.0)?);
            let (position, velocity) = self.engine.node(fiber, 0);
            done[fiber] = self.fresh[fiber]
                && self.engine.remembers(fiber)
                && sets_out_smoothly(&now.root, &then.root, &position, &velocity, dt);
        }
        self.working(|batch| {
            batch.engine.arrive();
            batch.engine.take_start(&done);
        });
        (0..self.rods.len()).for_each(|fiber| self.engine.undo(fiber));
        self.skip_start();
        Ok(())
    }

    /// Changes the loads of joints by these, and the increments of the last linearisation as these
    /// change them. Cost: a pass over the fibres to the tip and back.
    ///
    /// # Errors
    /// [`StepError`] for loads that make no sense.
    pub fn change_loads(&mut self, changes: JointLoads) -> Result<(), StepError> {
        self.check_loads(changes)?;
        self.check_under_way()?;
        self.working(|batch| batch.engine.change_loads(changes));
        Ok(())
    }

    /// Takes the increments of the last linearisation. Returns the largest increment, rad; those
    /// above 1 are shortened.
    ///
    /// # Errors
    /// [`StepError`] if an increment is not finite.
    pub fn take_increments(&mut self) -> Result<f64, StepError> {
        self.check_under_way()?;
        let turns = self.working(|batch| batch.engine.take_increments());
        self.largest(&turns)
    }

    /// Where the points are led by the step with the increments of the last linearisation, to first
    /// order: of nodes the displacement over the step, m, of segments the rotation by the
    /// increment, rad; world frame.
    ///
    /// # Errors
    /// [`RodError::Length`] unless there is one a point, [`RodError::Invalid`] for a point that is
    /// not on a fibre or if no step is under way.
    pub fn linear_ways(
        &self,
        points: &[LoadPoint],
        ways: &mut [Vector3<f64>],
    ) -> Result<(), RodError> {
        self.check_load_points(points)?;
        check("ways", points.len(), ways.len())?;
        self.engine.linear_ways(points, ways);
        Ok(())
    }

    /// By fibre, the change of the [ways](Self::linear_ways) of its points by loads at them, in the
    /// order of `points`: three rows and columns each, m or rad per N or N m, symmetric. Cost: a
    /// pass for each point over the fibre from there to the tip, for three columns at once.
    ///
    /// # Errors
    /// [`RodError::Invalid`] for a point that is not on a fibre or if no step is under way.
    pub fn load_responses(&mut self, points: &[LoadPoint]) -> Result<Vec<DMatrix<f64>>, RodError> {
        self.check_load_points(points)?;
        Ok(self.working(|batch| batch.engine.load_responses(points)))
    }

    /// Rotation from the material frame of a segment to the world, where a step under way has been
    /// solved to.
    ///
    /// # Panics
    /// If there is no such fibre or segment, as indexing does.
    #[must_use]
    pub fn frame(&self, fiber: usize, segment: usize) -> UnitQuaternion<f64> {
        self.engine.frame(fiber, segment)
    }

    fn check_load_points(&self, points: &[LoadPoint]) -> Result<(), RodError> {
        self.check_step()?;
        self.on_fibers(points)
    }

    fn on_fibers(&self, points: &[LoadPoint]) -> Result<(), RodError> {
        let segments = self.rods[0].fiber.segments();
        let there = |point: &LoadPoint| {
            let last = match point.place {
                LoadPlace::Node(_) => segments,
                LoadPlace::Segment(_) => segments - 1,
            };
            (point.fiber as usize) < self.rods.len() && point.first() <= last
        };
        if points.iter().all(there) {
            return Ok(());
        }
        let why = "each needs a fibre of the batch and a node or segment of it";
        Err(RodError::Invalid { what: "points", why })
    }

    fn check_loads(&self, JointLoads { points, loads }: JointLoads) -> Result<(), StepError> {
        let error = |why| {
            let (what, time) = ("the loads of joints", self.time());
            Err(StepError::Conditions { fiber: 0, what, time, why })
        };
        if points.len() != loads.len() || self.on_fibers(points).is_err() {
            return error("there must be one for each point on the fibres");
        }
        if loads.iter().flatten().any(|x| !x.is_finite()) {
            return error("must be finite (N, N m)");
        }
        Ok(())
    }
}
