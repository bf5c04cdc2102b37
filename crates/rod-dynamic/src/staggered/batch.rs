use super::check::{check_conditions, check_laws, check_state};
use super::erased_batch::{ErasedBatch, build};
use super::scheme::{Scheme, StepProblem};
use super::search::SearchOutcome;
use crate::joint::Joint;
use crate::{
    Conditions, End, Energy, Instant, Ledger, Momentum, Rod, RodError, RodState, RodStepReport,
    SectionLaws, StepError,
};
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::so3;
use rapunzel_lanes::LANES;

/// Largest number of halvings of a step.
const MAX_HALVINGS: usize = 12;
/// Length of the solve for the initial acceleration, as a fraction of the step size.
const START: f64 = 1.0;

/// Up to eight fibres with equally many segments, moved together in SIMD lanes.
///
/// Each fibre has its own conditions and its steps are halved on their own; its motion does not
/// depend on the other fibres in the batch. Cost: four to five Newton iterations a step, linear in
/// the number of segments; no allocation in a step that converges without halving. Memory: half a
/// kilobyte a segment, with backward Euler a third of one, and as much again once steps are taken
/// in several calls; rods that are copies of each other share their fibre. Each thread keeps one
/// workspace for the solve of one batch, as long as the longest rods it has moved.
///
/// The method is second order in time and in space. `rho_inf` is the spectral radius at infinite
/// frequency: 0 loses most, 0.3 is the default, above 0.4 a whip may need halving. Near 1 the
/// forces of the constraints oscillate ever more, as for any such method (Arnold and Bruls 2007),
/// and a long run ends.
pub struct StaggeredBatch {
    pub(super) engine: Box<dyn ErasedBatch>,
    pub(super) rods: Vec<Rod>,
    time: f64,
    /// Size of the step that is under way across calls, s; zero if none is.
    pub(super) predicted: f64,
    /// Whether accelerations are carried from step to step.
    memory: bool,
    /// Whether the initial acceleration of a fibre is still to be found.
    pub(super) fresh: [bool; LANES],
    /// Value of `fresh` before the step that has been predicted.
    pub(super) fresh_before: [bool; LANES],
    /// Ledgers of the last step, if they are kept.
    ledgers: Option<[Ledger; LANES]>,
}

impl StaggeredBatch {
    /// Largest number of fibres in a batch.
    pub const MAX_FIBERS: usize = LANES;
    /// The default spectral radius at infinite frequency.
    pub const DEFAULT_RHO_INF: f64 = 0.3;

    /// Creates fibres at rest in their natural shape, each at its root pose, at time 0.
    ///
    /// # Errors
    /// [`RodError::Invalid`] unless there are 1 to 8 rods of equally many segments, at least two,
    /// with damping times that are finite and not negative, and `0 <= rho_inf <= 1`; and for laws
    /// beside a damping time. [`RodError::Length`] for laws that are not one a node.
    pub fn new(rods: Vec<Rod>, rho_inf: f64) -> Result<Self, RodError> {
        if !(0.0..=1.0).contains(&rho_inf) {
            return Err(RodError::Invalid { what: "rho_inf", why: "must be between 0 and 1" });
        }
        Self::with_scheme(rods, Scheme::new(rho_inf))
    }

    /// Creates fibres as [`StaggeredBatch::new`] does, integrated with the backward Euler method:
    /// first order in time. It damps more, but the velocity at the end of a step is the mean
    /// velocity over the step, so that a node stopped by an impulse stays at rest, and contact
    /// forces need no acceleration to balance them.
    ///
    /// # Errors
    /// As [`StaggeredBatch::new`].
    pub fn backward_euler(rods: Vec<Rod>) -> Result<Self, RodError> {
        Self::with_scheme(rods, Scheme::backward_euler())
    }

    fn with_scheme(rods: Vec<Rod>, scheme: Scheme) -> Result<Self, RodError> {
        let invalid = |what, why| Err(RodError::Invalid { what, why });
        if rods.is_empty() || rods.len() > Self::MAX_FIBERS {
            return invalid("rods", "a batch has 1 to 8 rods");
        }
        let n = rods[0].fiber.segments();
        if n < 2 || rods.iter().any(|rod| rod.fiber.segments() != n) {
            return invalid("rods", "all need the same number of segments, at least 2");
        }
        if rods.iter().any(|rod| !(rod.damping_time >= 0.0 && rod.damping_time.is_finite())) {
            return invalid("damping time", "must be finite and not negative (s)");
        }
        rods.iter().try_for_each(check_laws)?;
        let engine = build(&rods, scheme);
        let memory = scheme.has_memory();
        let (fresh, fresh_before) = ([true; LANES], [true; LANES]);
        let mut batch = Self {
            engine,
            rods,
            time: 0.0,
            predicted: 0.0,
            memory,
            fresh,
            fresh_before,
            ledgers: None,
        };
        for fiber in 0..batch.rods.len() {
            let state = natural_state(&batch.rods[fiber]);
            batch.set_state(fiber, &state)?;
        }
        Ok(batch)
    }

    /// The rods of the batch.
    #[must_use]
    pub fn rods(&self) -> &[Rod] {
        &self.rods
    }

    /// Current time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// State of one fibre. Forces are those at the end of the last step, zero before the first.
    #[must_use]
    pub fn state(&self, fiber: usize) -> RodState {
        self.engine.state(fiber, &self.rods[fiber], self.time)
    }

    /// Position (m) and velocity (m/s) of one node, world frame.
    #[must_use]
    pub fn node(&self, fiber: usize, node: usize) -> (Point3<f64>, Vector3<f64>) {
        self.engine.node(fiber, node)
    }

    /// Energy of one fibre in the given gravity (m/s^2).
    #[must_use]
    pub fn energy(&self, fiber: usize, gravity: &Vector3<f64>) -> Energy {
        self.engine.energy(fiber, gravity)
    }

    /// Momentum of one fibre.
    #[must_use]
    pub fn momentum(&self, fiber: usize) -> Momentum {
        self.engine.momentum(fiber)
    }

    /// Keeps ledgers of the steps from now on, or stops keeping them. They cost a pass over the
    /// rods in each step, and do not change the motion.
    pub fn keep_ledgers(&mut self, keep: bool) {
        self.ledgers = keep.then(Default::default);
    }

    /// Energy ledger of one fibre in the last step that was taken, `None` if ledgers are not kept.
    #[must_use]
    pub fn ledger(&self, fiber: usize) -> Option<Ledger> {
        self.ledgers.map(|ledgers| ledgers[fiber])
    }

    /// Restarts one fibre from `state`; the batch takes over its time.
    ///
    /// # Errors
    /// As [`crate::RodIntegrator::set_state`].
    pub fn set_state(&mut self, fiber: usize, state: &RodState) -> Result<(), RodError> {
        check_state(&self.rods[fiber], state)?;
        self.engine.set_state(fiber, &self.rods[fiber], state);
        self.time = state.time;
        self.fresh[fiber] = true;
        Ok(())
    }

    /// Replaces the section laws of one fibre, for example when the climate has changed; the memory
    /// of the sections is kept.
    ///
    /// # Errors
    /// [`RodError::Invalid`] unless the new laws remember as much as those before, and
    /// [`RodError::Length`] unless they are one a node.
    pub fn set_laws(&mut self, fiber: usize, laws: SectionLaws) -> Result<(), RodError> {
        let rod = &mut self.rods[fiber];
        let memories = |laws: &SectionLaws, node| laws.at(node).map(|law| law.memory());
        let mut nodes = 0..=rod.fiber.segments();
        if nodes.any(|node| memories(&laws, node) != memories(&rod.laws, node)) {
            let why = "must remember as many vectors in each section as those before";
            return Err(RodError::Invalid { what: "laws", why });
        }
        rod.laws = laws;
        check_laws(rod)?;
        self.engine.set_laws(fiber, rod);
        Ok(())
    }

    /// Sets additional forces on the nodes of one fibre, N, world, constant until set again.
    ///
    /// # Errors
    /// [`RodError::Length`] unless there is one per node.
    pub fn set_node_forces(
        &mut self,
        fiber: usize,
        forces: &[Vector3<f64>],
    ) -> Result<(), RodError> {
        let expected = self.rods[fiber].fiber.segments() + 1;
        if forces.len() != expected {
            return Err(RodError::Length { what: "forces", expected, found: forces.len() });
        }
        if forces.iter().flatten().any(|x| !x.is_finite()) {
            return Err(RodError::Invalid { what: "forces", why: "must be finite (N)" });
        }
        for (node, force) in forces.iter().enumerate() {
            self.engine.set_node_force(fiber, node, force);
        }
        Ok(())
    }

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
            ends[fiber] = Some(self.conditions(fiber, self.time + dt, conditions[fiber])?);
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
        if !self.memory {
            self.fresh = [false; LANES];
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

    /// The conditions of one fibre at `time`, checked.
    fn conditions(
        &self,
        fiber: usize,
        time: f64,
        conditions: &dyn Conditions,
    ) -> Result<Instant, StepError> {
        let now = conditions.at(time);
        check_conditions(&self.rods[fiber], &now, time).map_err(|e| e.renumbered(|_| fiber))?;
        Ok(now)
    }

    /// Appends all numbers that determine the further motion.
    pub fn save(&self, numbers: &mut Vec<f64>) {
        numbers.reserve_exact(self.numbers());
        numbers.push(self.time);
        for fiber in 0..self.rods.len() {
            numbers.push(f64::from(self.fresh[fiber]));
            self.engine.save(fiber, numbers);
        }
    }

    /// How many numbers [`StaggeredBatch::save`] appends.
    fn numbers(&self) -> usize {
        1 + (0..self.rods.len()).map(|fiber| 1 + self.engine.numbers(fiber)).sum::<usize>()
    }

    /// Restores the state from the numbers that [`StaggeredBatch::save`] wrote.
    ///
    /// # Errors
    /// [`RodError::Length`] when the count is not that of these rods.
    pub fn restore(&mut self, numbers: &[f64]) -> Result<(), RodError> {
        let expected = self.numbers();
        let Some((time, mut rest)) = numbers.split_first().filter(|_| numbers.len() == expected)
        else {
            return Err(RodError::Length { what: "numbers", expected, found: numbers.len() });
        };
        self.time = *time;
        for fiber in 0..self.rods.len() {
            self.fresh[fiber] = rest[0] > 0.0;
            rest = self.engine.restore(fiber, &rest[1..]);
        }
        Ok(())
    }
}

/// State of a rod at rest in its natural shape, in which no joint has a moment.
fn natural_state(rod: &Rod) -> RodState {
    let fiber = &rod.fiber;
    let n = fiber.segments();
    let mut frame = fiber.root().rotation.to_rotation_matrix();
    let mut position = Point3::from(fiber.root().translation.vector);
    let (mut positions, mut frames) = (vec![position], Vec::with_capacity(n));
    for (e, h) in fiber.segment_lengths().iter().enumerate() {
        frame *= so3::exp(&Joint::new(fiber, e).rest);
        position += *h * frame.matrix().column(2);
        frames.push(frame);
        positions.push(position);
    }
    RodState {
        time: 0.0,
        positions,
        velocities: vec![Vector3::zeros(); n + 1],
        frames,
        angular_velocities: vec![Vector3::zeros(); n],
        forces: vec![Vector3::zeros(); n],
        curvatures: fiber.nodes().iter().map(|node| node.natural_curvature).collect(),
    }
}

/// Whether the root's prescribed motion continues the velocity that the rod starts with, so that
/// an acceleration at the start exists: compared are the first and the second difference quotient.
fn sets_out_smoothly(
    now: &End,
    then: &End,
    position: &Point3<f64>,
    velocity: &Vector3<f64>,
    delta: f64,
) -> bool {
    let place = |end: &End| match end {
        End::Held(pose) => Some(pose.translation.vector),
        End::Pinned { position, .. } => Some(position.coords),
        End::Loaded { .. } => None,
    };
    let (Some(first), Some(second)) = (place(now), place(then)) else { return true };
    let jump = (first - position.coords) / delta - velocity;
    let change = (second - 2.0 * first + position.coords) / delta;
    let speed = velocity.norm().max(((second - first) / delta).norm());
    jump.norm() <= change.norm() + 1e-9 * speed
}
