//! Steps in Newton iterations, for a contact solver between them.

use super::batch::StaggeredBatch;
use super::response::Inertia;
use crate::{
    Conditions, ImpulseResponse, Impulses, Point, PointAction, PointResponses, RodError,
    RodStepReport, StepError,
};
use nalgebra::{Matrix3, Vector3};
use rapunzel_lanes::{LANES, all_finite};

const NOT_UNDER_WAY: &str = "none is under way: set out on one";
const UNSOUND_POINT: &str =
    "each needs a fibre, a segment, a fraction in 0..=1 and a finite arm or lever";

impl StaggeredBatch {
    /// Starts a step of `dt` seconds with `impulses` at its start, at the predicted shape, without
    /// solving it: [`Self::linearize`] and [`Self::advance`] do that, one Newton iteration after
    /// another, until [`Self::accept`] or [`Self::abandon`]. Such a step is not halved, since
    /// bodies in contact must take the same step.
    ///
    /// # Errors
    /// [`StepError`] for conditions and impulses that make no sense: [`StepError::Conditions`] for
    /// points that are on no fibre, other than one impulse a point, or what is not finite. The
    /// fibres are then as before.
    ///
    /// # Panics
    /// If there are fewer conditions or reports than fibres.
    pub fn set_out(
        &mut self,
        dt: f64,
        conditions: &[&dyn Conditions],
        impulses: Impulses,
        reports: &mut [RodStepReport],
    ) -> Result<(), StepError> {
        self.keep_step();
        self.is_linearized = true;
        self.working(|batch| {
            batch.begin(dt, conditions, reports)?;
            let set = batch.set_impulses(impulses);
            if set.is_ok() {
                batch.engine.look(dt);
            }
            batch.under_way(dt, set)
        })
    }

    /// Starts a step of `dt` seconds without impulses, and takes the first Newton iteration at
    /// once, which costs less than [`Self::set_out`] and those two calls. Returns the largest
    /// increment, rad. Where no fibre of a [hybrid](Self::hybrid) batch bears anything, the matrix
    /// of that iteration is not kept: what asks for one linearises anew.
    ///
    /// # Errors
    /// [`StepError`] for conditions that make no sense, and where Newton's equations have no
    /// solution. The fibres are then as before.
    ///
    /// # Panics
    /// If there are fewer conditions or reports than fibres.
    pub fn set_out_free(
        &mut self,
        dt: f64,
        conditions: &[&dyn Conditions],
        reports: &mut [RodStepReport],
    ) -> Result<f64, StepError> {
        self.keep_step();
        let fibers = self.rods.len();
        let flies = self.flight.is_some() && (0..fibers).all(|fiber| !self.bears(fiber));
        let turns = self.working(|batch| {
            batch.begin(dt, conditions, reports)?;
            batch.engine.hold_workspace(true);
            if flies {
                batch.engine.exchange_linearization();
            }
            batch.engine.look(dt);
            batch.engine.linearize();
            let turns = batch.engine.advance(Impulses::NONE);
            if flies {
                batch.engine.exchange_linearization();
            }
            batch.engine.hold_workspace(false);
            Ok(turns)
        })?;
        self.is_linearized = !flies;
        self.predicted = dt;
        let turn = self.largest(&turns);
        if turn.is_err() {
            self.abandon();
        }
        turn
    }

    /// Lets the batch keep what a step in several calls needs, and what it was before.
    fn keep_step(&mut self) {
        self.fresh_before = self.fresh;
        self.engine.hold_workspace(false);
        self.engine.keep();
    }

    /// Solves Newton's equations at the present shape of the step under way, without taking the
    /// increments: [`StepVelocity::Linear`](super::StepVelocity) and [`ImpulseResponse`] then refer
    /// to them. Returns the largest increment, rad.
    ///
    /// # Errors
    /// [`StepError::NotConverged`] if they have no solution.
    pub fn linearize(&mut self) -> Result<f64, StepError> {
        self.check_under_way()?;
        self.is_linearized = true;
        let turns = self.working(|batch| batch.engine.linearize());
        self.largest(&turns)
    }

    /// Linearises the rods where they are, if no linearisation was kept.
    fn need_linearization(&mut self) {
        if !self.is_linearized {
            self.is_linearized = true;
            self.working(|batch| batch.engine.linearize());
        }
    }

    /// Replaces the impulses of the step under way. The shape is unchanged: the
    /// impulses enter the next [`Self::linearize`]. Returns whether they are others than before.
    ///
    /// # Errors
    /// As [`Self::set_out`] for impulses that make no sense.
    pub fn press(&mut self, impulses: Impulses) -> Result<bool, StepError> {
        self.check_under_way()?;
        self.check_impulses(impulses)?;
        Ok(self.working(|batch| batch.engine.press(impulses)))
    }

    /// Takes the increments of the last linearisation, with these impulses in place of those
    /// before. Returns the largest increment, rad; those above 1 are shortened. Asked again without
    /// a linearisation between, it takes what the change of the impulses causes by the matrix of
    /// the last one: a chord step, which costs less and is as good where the rods have hardly
    /// turned since.
    ///
    /// # Errors
    /// [`StepError`] as [`Self::set_out`] and [`Self::linearize`].
    pub fn advance(&mut self, impulses: Impulses) -> Result<f64, StepError> {
        self.check_impulses(impulses)?;
        self.check_under_way()?;
        self.need_linearization();
        let turns = self.working(|batch| batch.engine.advance(impulses));
        self.largest(&turns)
    }

    /// Largest of the increments of all fibres, rad; an error if one is not finite.
    pub(super) fn largest(&self, turns: &[f64; LANES]) -> Result<f64, StepError> {
        let turns = &turns[..self.rods.len()];
        if let Some(fiber) = turns.iter().position(|turn| !turn.is_finite()) {
            let (time, dt, residuals) = (self.time(), self.predicted, vec![turns[fiber]]);
            return Err(StepError::NotConverged { fiber, time, dt, residuals });
        }
        Ok(turns.iter().copied().fold(0.0, f64::max))
    }

    /// Makes the result of the last solve the state; does nothing if no step is under way.
    pub fn accept(&mut self) {
        let dt = std::mem::take(&mut self.predicted);
        if dt > 0.0 {
            let mut all = [false; LANES];
            all[..self.rods().len()].fill(true);
            self.working(|batch| {
                batch.engine.arrive();
                batch.commit(&[dt; LANES], &all);
            });
            self.advance_time(dt);
            self.take_methods();
        }
    }

    /// Restores the fibres to before the step that is under way, if one is.
    pub fn abandon(&mut self) {
        if std::mem::take(&mut self.predicted) > 0.0 {
            self.take_back(self.fresh_before);
            self.take_methods();
        }
    }

    /// Marks a step of `dt` seconds as under way if `done` is `Ok`, else restores the fibres.
    pub(super) fn under_way(
        &mut self,
        dt: f64,
        done: Result<(), StepError>,
    ) -> Result<(), StepError> {
        self.predicted = dt;
        if done.is_err() {
            self.abandon();
        }
        done
    }

    pub(super) fn check_under_way(&self) -> Result<(), StepError> {
        self.check_step().map_err(|_| StepError::Conditions {
            fiber: 0,
            what: "step",
            time: self.time(),
            why: NOT_UNDER_WAY,
        })
    }

    pub(super) fn check_step(&self) -> Result<(), RodError> {
        if self.predicted > 0.0 {
            Ok(())
        } else {
            Err(RodError::Invalid { what: "step", why: NOT_UNDER_WAY })
        }
    }

    fn check_impulses(&self, all: Impulses) -> Result<(), StepError> {
        let Impulses { points, impulses } = all;
        let (what, time) = ("impulses", self.time());
        let error = |fiber, why| Err(StepError::Conditions { fiber, what, time, why });
        if points.len() != impulses.len() {
            return error(0, "there must be one for each point");
        }
        if !self.are_sound(points) {
            return error(0, UNSOUND_POINT);
        }
        // The search for the culprit only where there is one.
        if !all_finite(impulses, |&p| p.into()) {
            let finite = |p: &Vector3<f64>| p.iter().all(|x| x.is_finite());
            let culprit = impulses.iter().position(|p| !finite(p)).unwrap_or_default();
            return error(points[culprit].fiber as usize, "must be finite (N s)");
        }
        Ok(())
    }

    fn set_impulses(&mut self, impulses: Impulses) -> Result<(), StepError> {
        self.check_impulses(impulses)?;
        self.engine.set_impulses(impulses);
        Ok(())
    }

    /// Whether the root and the tip of a fibre are clamped in the step under way.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    #[must_use]
    pub fn clamps(&self, fiber: usize) -> [bool; 2] {
        self.engine.clamps(fiber)
    }

    /// Writes the mean velocities of points that impulses on them cause, with the given inertia.
    fn answer(
        &mut self,
        points: &[Point],
        impulses: &[Vector3<f64>],
        inertia: Inertia,
        velocities: &mut [Vector3<f64>],
    ) -> Result<(), RodError> {
        check("impulses", points.len(), impulses.len())?;
        check("velocities", points.len(), velocities.len())?;
        self.check_points(points)?;
        self.need_linearization();
        self.working(|batch| batch.engine.respond_at(points, impulses, inertia, velocities));
        Ok(())
    }

    fn check_points(&self, points: &[Point]) -> Result<(), RodError> {
        self.check_step()?;
        let sound = self.are_sound(points);
        sound.then_some(()).ok_or(RodError::Invalid { what: "points", why: UNSOUND_POINT })
    }

    /// Whether all points are on fibres of the batch.
    fn are_sound(&self, points: &[Point]) -> bool {
        let (fibers, segments) = (self.rods().len(), self.rods()[0].fiber.segments());
        // No early exit, so that the loop can be vectorised.
        let (mut fiber, mut segment, mut sound) = (0, 0, true);
        for p in points {
            (fiber, segment) = (p.fiber.max(fiber), p.segment.max(segment));
            sound &= match p.action {
                PointAction::Force { fraction, arm } => {
                    (0.0..=1.0).contains(&fraction) && arm.sum().is_finite()
                }
                PointAction::Couple { lever } => lever.sum().is_finite(),
            };
        }
        sound && (fiber as usize) < fibers && (segment as usize) < segments
    }
}

impl ImpulseResponse for StaggeredBatch {
    fn nodes(&self) -> usize {
        self.rods().len() * (self.rods()[0].fiber.segments() + 1)
    }

    fn respond(
        &mut self,
        impulses: &[Vector3<f64>],
        velocities: &mut [Vector3<f64>],
    ) -> Result<(), RodError> {
        check("impulses", self.nodes(), impulses.len())?;
        check("velocities", self.nodes(), velocities.len())?;
        self.check_step()?;
        self.need_linearization();
        let fibers = self.rods.len();
        self.working(|batch| batch.engine.respond(fibers, impulses, velocities));
        Ok(())
    }

    fn diagonal_blocks(
        &mut self,
        nodes: &mut [Matrix3<f64>],
        segments: &mut [Matrix3<f64>],
    ) -> Result<(), RodError> {
        let fibers = self.rods.len();
        check("nodes", self.nodes(), nodes.len())?;
        check("segments", self.nodes() - fibers, segments.len())?;
        self.check_step()?;
        self.need_linearization();
        self.working(|batch| batch.engine.diagonal_blocks(fibers, nodes, segments));
        Ok(())
    }

    fn respond_at(
        &mut self,
        points: &[Point],
        impulses: &[Vector3<f64>],
        velocities: &mut [Vector3<f64>],
    ) -> Result<(), RodError> {
        self.answer(points, impulses, Inertia::Own, velocities)
    }

    fn weighted_respond_at(
        &mut self,
        points: &[Point],
        impulses: &[Vector3<f64>],
        velocities: &mut [Vector3<f64>],
    ) -> Result<(), RodError> {
        self.answer(points, impulses, Inertia::Weighted, velocities)
    }

    fn write_out(&mut self, points: &[Point]) -> Result<Vec<PointResponses>, RodError> {
        self.check_points(points)?;
        self.need_linearization();
        Ok(self.working(|batch| batch.engine.write_out(points)))
    }

    fn set_weights(&mut self, points: &[Point], masses: &[f64]) -> Result<(), RodError> {
        check("masses", points.len(), masses.len())?;
        self.check_points(points)?;
        if !masses.iter().all(|m| *m >= 0.0 && m.is_finite()) {
            return Err(RodError::Invalid { what: "masses", why: "must be finite and >= 0 (kg)" });
        }
        self.need_linearization();
        self.working(|batch| batch.engine.weigh(points, masses));
        Ok(())
    }
}

pub(super) fn check(what: &'static str, expected: usize, found: usize) -> Result<(), RodError> {
    if expected == found { Ok(()) } else { Err(RodError::Length { what, expected, found }) }
}
