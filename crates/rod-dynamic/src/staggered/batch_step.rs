//! A step of a batch: attempted whole by all its fibres at once, and in halves by each that fails.

use super::batch::StaggeredBatch;
use super::check::check_conditions;
use super::scheme::StepProblem;
use super::search::SearchOutcome;
use crate::{Conditions, End, Instant, RodStepReport, StepError};
use nalgebra::{Matrix3, Point3, Vector3};
use rapunzel_lanes::LANES;

/// Largest number of halvings of a step.
const MAX_HALVINGS: usize = 12;
/// Length of the solve for the initial acceleration, as a fraction of the step size.
const START: f64 = 1.0;

impl StaggeredBatch {
    /// Advances all fibres by `dt` seconds, fibre `i` under `conditions[i]`, and writes iterations
    /// and residual of the step to `reports[i]`.
    ///
    /// # Errors
    /// [`StepError`]; all fibres are then as before.
    ///
    /// # Panics
    /// If there are fewer conditions or reports than fibres.
    pub fn step(
        &mut self,
        dt: f64,
        conditions: &[&dyn Conditions],
        reports: &mut [RodStepReport],
    ) -> Result<(), StepError> {
        self.working(|batch| batch.step_whole(dt, conditions, reports))
    }

    /// Runs `act` with a borrowed workspace.
    pub(super) fn working<T>(&mut self, act: impl FnOnce(&mut Self) -> T) -> T {
        self.engine.enter();
        let done = act(self);
        self.engine.leave();
        done
    }

    fn step_whole(
        &mut self,
        dt: f64,
        conditions: &[&dyn Conditions],
        reports: &mut [RodStepReport],
    ) -> Result<(), StepError> {
        let fresh = self.fresh;
        let wanted = self.begin(dt, conditions, reports)?;
        let count = self.rods.len();
        let mut out = [SearchOutcome::NONE; LANES];
        let mut lengths = [dt; LANES];
        self.engine.attempt(&lengths, &wanted, StepProblem::Step, &mut out);
        let mut whole = wanted;
        // Saved state of the fibres that go on in parts, as the step started.
        let mut before = Vec::new();
        for fiber in 0..count {
            reports[fiber] = out[fiber].report();
            if !out[fiber].converged {
                whole[fiber] = false;
                self.engine.undo(fiber);
                let mut numbers = Vec::new();
                self.engine.save(fiber, &mut numbers);
                before.push((fiber, numbers));
                let result = self.creep(fiber, dt, conditions[fiber], &mut lengths, &out[fiber]);
                match result {
                    Ok(report) => {
                        reports[fiber].iterations += report.iterations;
                        reports[fiber].halvings = report.halvings;
                        reports[fiber].residual = report.residual;
                    }
                    Err(error) => {
                        for (fiber, numbers) in before {
                            self.engine.restore(fiber, &numbers);
                        }
                        self.take_back(fresh);
                        return Err(error);
                    }
                }
                lengths[fiber] = dt;
            }
        }
        self.commit(&lengths, &whole);
        self.advance_time(dt);
        Ok(())
    }

    /// Checks a step, finds initial accelerations where they are still missing, and sets the
    /// conditions at the end of the step. Returns the lanes in use.
    pub(super) fn begin(
        &mut self,
        dt: f64,
        conditions: &[&dyn Conditions],
        reports: &[RodStepReport],
    ) -> Result<[bool; LANES], StepError> {
        let count = self.rods.len();
        assert!(conditions.len() >= count && reports.len() >= count, "one for each fibre");
        if !(dt > 0.0 && dt.is_finite()) {
            return Err(StepError::TimeStep(dt));
        }
        let mut ends = [None; LANES];
        for fiber in 0..count {
            let now = self.conditions(fiber, self.time + dt, conditions[fiber])?;
            self.check_feed(fiber, &now)?;
            ends[fiber] = Some(now);
        }
        self.open_ledgers(conditions)?;
        self.engine.remember();
        self.engine.set_out(&[true; LANES]);
        let fresh = self.fresh;
        if let Err(error) = self.start(dt, conditions) {
            self.take_back(fresh);
            return Err(error);
        }
        let mut used = [false; LANES];
        for (fiber, now) in ends.iter().enumerate() {
            if let Some(now) = now {
                self.engine.set_conditions(fiber, now);
                used[fiber] = true;
            }
        }
        Ok(used)
    }

    /// Refuses a feed that a step cannot follow.
    fn check_feed(&self, fiber: usize, now: &Instant) -> Result<(), StepError> {
        let lengths = self.rods[fiber].fiber.segment_lengths();
        let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
        let fed = (self.engine.inside_nozzle(fiber) - now.inside).abs();
        if fed <= shortest || self.fresh[fiber] {
            return Ok(());
        }
        let why = "feeds more than a segment in a step: take shorter steps, or feed more slowly";
        Err(StepError::Conditions { fiber, what: "nozzle", time: self.time, why })
    }

    /// Begins the ledgers of a step, if they are kept.
    fn open_ledgers(&mut self, conditions: &[&dyn Conditions]) -> Result<(), StepError> {
        if self.ledgers.is_some() {
            for (fiber, conditions) in conditions.iter().enumerate().take(self.rods.len()) {
                let now = self.conditions(fiber, self.time, *conditions)?;
                self.engine.open_ledger(fiber, &now, !self.fresh[fiber]);
            }
            self.ledgers = Some(Default::default());
        }
        Ok(())
    }

    /// Makes the last attempt the state of the fibres that are `done`, and adds it to their
    /// ledgers.
    pub(super) fn commit(&mut self, lengths: &[f64; LANES], done: &[bool; LANES]) {
        if let Some(ledgers) = &mut self.ledgers {
            let booked = self.engine.account(lengths, done);
            for fiber in (0..self.rods.len()).filter(|&fiber| done[fiber]) {
                ledgers[fiber] += booked[fiber];
            }
        }
        self.engine.commit(lengths, done, StepProblem::Step);
    }

    /// Undoes everything that a failed step has changed.
    pub(super) fn take_back(&mut self, fresh: [bool; LANES]) {
        self.engine.undo_all(&fresh);
        self.fresh = fresh;
    }

    /// Lets all fibres start without an initial acceleration.
    pub(super) fn skip_start(&mut self) {
        self.fresh = [false; LANES];
    }

    pub(super) fn advance_time(&mut self, dt: f64) {
        self.time += dt;
    }

    /// Takes one fibre through the step in parts, which are halved until they converge.
    fn creep(
        &mut self,
        fiber: usize,
        dt: f64,
        conditions: &dyn Conditions,
        lengths: &mut [f64; LANES],
        failed: &SearchOutcome,
    ) -> Result<RodStepReport, StepError> {
        let mut out = [SearchOutcome::NONE; LANES];
        out[fiber] = *failed;
        let mut only = [false; LANES];
        only[fiber] = true;
        // Progress is counted in parts of the finest length, so that the last part ends exactly.
        let total = 1_u32 << MAX_HALVINGS;
        let (mut done, mut part) = (0_u32, total);
        let mut report = RodStepReport::default();
        while done < total {
            // The last attempt failed: halve the part, unless it is the finest.
            if !out[fiber].converged {
                if part == 1 {
                    return Err(StepError::NotConverged {
                        fiber,
                        time: self.time + dt * f64::from(done) / f64::from(total),
                        dt: lengths[fiber],
                        residuals: out[fiber].residuals[..out[fiber].iterations].to_vec(),
                    });
                }
                part /= 2;
                report.halvings += 1;
            }
            // Attempt the next part, and commit it or go back to its start.
            lengths[fiber] = dt * f64::from(part) / f64::from(total);
            let end = self.time + dt * f64::from(done + part) / f64::from(total);
            let now = self.conditions(fiber, end, conditions)?;
            self.engine.set_conditions(fiber, &now);
            let mut before = Vec::new();
            self.engine.save(fiber, &mut before);
            self.engine.set_out(&only);
            self.engine.attempt(lengths, &only, StepProblem::Step, &mut out);
            report.iterations += out[fiber].iterations;
            if out[fiber].converged {
                self.commit(lengths, &only);
                done += part;
            } else {
                self.engine.restore(fiber, &before);
            }
        }
        report.residual = out[fiber].report().residual;
        Ok(report)
    }

    /// Finds the initial accelerations of fibres whose state has just been set.
    fn start(&mut self, dt: f64, conditions: &[&dyn Conditions]) -> Result<(), StepError> {
        let count = self.rods.len();
        let delta = START * dt;
        let mut wanted = [false; LANES];
        // Rotations of the joints under the conditions at the start.
        if self.fresh[..count].contains(&true) {
            for fiber in (0..count).filter(|&fiber| self.fresh[fiber]) {
                let now = self.conditions(fiber, self.time, conditions[fiber])?;
                self.engine.set_conditions(fiber, &now);
            }
            self.engine.measure(&self.fresh);
        }
        for fiber in 0..count {
            self.fresh[fiber] &= self.engine.remembers(fiber);
        }
        // Lanes in which an initial acceleration exists, and the conditions of the solve for it.
        for fiber in (0..count).filter(|&fiber| self.fresh[fiber]) {
            let at =
                |part: f64| self.conditions(fiber, self.time + part * delta, conditions[fiber]);
            let (now, then) = (at(1.0)?, at(2.0)?);
            let (position, velocity) = self.engine.node(fiber, 0);
            wanted[fiber] = sets_out_smoothly(&now.root, &then.root, &position, &velocity, delta);
            self.engine.set_conditions(fiber, &now);
        }
        // Solve for the accelerations; rotations go back to the start.
        if wanted.contains(&true) {
            let mut out = [SearchOutcome::NONE; LANES];
            let lengths = [delta; LANES];
            self.engine.attempt(&lengths, &wanted, StepProblem::Start, &mut out);
            let mut done = wanted;
            for fiber in 0..count {
                done[fiber] &= out[fiber].converged;
            }
            self.engine.commit(&lengths, &done, StepProblem::Start);
            for fiber in (0..count).filter(|&fiber| wanted[fiber]) {
                self.engine.undo(fiber);
            }
        }
        self.fresh = [false; LANES];
        Ok(())
    }

    /// The conditions of one fibre at `time`, validated.
    pub(super) fn conditions(
        &self,
        fiber: usize,
        time: f64,
        conditions: &dyn Conditions,
    ) -> Result<Instant, StepError> {
        let now = conditions.at(time);
        check_conditions(&self.rods[fiber], &now, time).map_err(|e| e.renumbered(|_| fiber))?;
        Ok(now)
    }
}

/// Whether the root's prescribed motion continues the velocity that the rod starts with, so that
/// an acceleration at the start exists: compared are the first and the second difference quotient.
pub(super) fn sets_out_smoothly(
    now: &End,
    then: &End,
    position: &Point3<f64>,
    velocity: &Vector3<f64>,
    delta: f64,
) -> bool {
    // The prescribed place, and the projector on what is prescribed of it.
    let place = |end: &End| match end {
        End::Held(pose) => Some((pose.translation.vector, Matrix3::identity())),
        End::Pinned { position, .. } => Some((position.coords, Matrix3::identity())),
        End::Loaded { .. } => None,
        End::Supported(support) => Some((support.pose.translation.vector, support.held())),
    };
    let (Some((first, held)), Some((second, _))) = (place(now), place(then)) else { return true };
    let jump = held * ((first - position.coords) / delta - velocity);
    let change = held * ((second - 2.0 * first + position.coords) / delta);
    let speed = velocity.norm().max(((second - first) / delta).norm());
    jump.norm() <= change.norm() + 1e-9 * speed
}
