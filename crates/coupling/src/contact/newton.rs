//! Newton's method for rods and contacts of one list together, inexact: its iterations solve the
//! contacts only as well as they are worth (`ForcingTerm`).

use super::detection;
use super::forcing_term::ForcingTerm;
use super::problem::ContactProblem;
use super::problem::groups::LAST_TURN;
use super::stepper::{ContactStepper, PATIENCE};
use super::substep::Substep;
use super::substep_failure::SubstepFailure;
use super::system::CoupledSystem;
use crate::FiberGroup;
use crate::contact_point::ContactPoint;
use crate::phase_times::PhaseTimer;
use rapunzel_collision::CollisionError;
use rapunzel_contact::Tolerance;
use rapunzel_rod_dynamic::Impulses;
use rapunzel_scene::{ContactMethod, ContactSettings};

/// Most iterations of Newton's method with one list of contacts.
const MOST_ITERATIONS: usize = 8;
/// Increments below this, rad, need not be taken.
const SMALL_TURN: f64 = 1e-4;
/// Where segments still turn by more than this, rad, the step leads nowhere: two shorter ones cost
/// less.
const LOST: f64 = 0.5;
/// Dense contacts take longer: so many times the iterations follow those that did not do.
const LONGER: usize = 4;
/// What they must leave of the error, or the step leads nowhere.
const PROGRESS: f64 = 0.3;
/// An error below which fibres are so near to where they go, in tolerances, that it is seen which
/// contacts will not do.
const CLOSE: f64 = 60.0;

impl ContactStepper {
    /// Solves the step with the contacts of a case, of the list of this number, from this effort
    /// on. Tells whether rods and contacts are within their tolerances. Where all fly apart they
    /// are not listed again: what is swept then could be everything.
    pub(super) fn converge(
        &mut self,
        system: &mut CoupledSystem,
        part: &mut Substep,
        case: &mut ContactProblem,
        list: usize,
        mut effort: ForcingTerm,
        last: bool,
    ) -> Result<bool, SubstepFailure> {
        let patient = list >= PATIENCE;
        let (mut turn, mut longer, mut exact) = (f64::INFINITY, false, false);
        for _ in 0..MOST_ITERATIONS {
            let error = case.error().unwrap_or(f64::INFINITY);
            let solved = exact && error <= 1.0;
            if solved && turn < LAST_TURN {
                return Ok(true);
            }
            // The first list is of another end, and soon seen not to do.
            if list == 0 && !solved && error < CLOSE && self.strays(system, part, case)? {
                return Ok(false);
            }
            let still = part.still(&case.working_groups(system));
            let mut laps = PhaseTimer::start(self.stopwatch);
            let own = largest(&system.fibers.for_groups(&still, |group| group.linearize())?);
            laps.lap(&mut self.times.rods);
            if solved && own < SMALL_TURN {
                return Ok(true);
            }
            let (increment, reached) =
                self.iterate(system, part, case, effort, (patient, still))?;
            (turn, exact) = (increment, effort.is_last());
            // Fibres may be so entangled by where the step began that no impulses let them through.
            let left = case.error().unwrap_or(f64::INFINITY);
            if !reached && longer && !last && left > PROGRESS * error {
                return Err(SubstepFailure::Contacts(case.worst(system, part.time)));
            }
            longer = !reached;
            effort =
                if longer { effort.again(LONGER) } else { self.of_use(ForcingTerm::after(left)) };
        }
        if turn > LOST {
            Err(SubstepFailure::Contacts(case.worst(system, part.time)))
        } else {
            Ok(false)
        }
    }

    /// One iteration of Newton's method, with the rods as they are linearised, but groups that are
    /// `still`. Returns the largest increment, rad, and whether the contacts were solved as well as
    /// asked.
    fn iterate(
        &mut self,
        system: &mut CoupledSystem,
        part: &mut Substep,
        case: &mut ContactProblem,
        effort: ForcingTerm,
        (patient, mut still): (bool, Vec<bool>),
    ) -> Result<(f64, bool), SubstepFailure> {
        self.solver.set_tolerance(effort.of(&self.tolerance(part.dt)));
        let mut laps = PhaseTimer::start(self.stopwatch);
        let before = case.working_groups(system);
        let one = case.solve(system, &mut self.solver, patient)?;
        laps.lap(&mut self.times.solver);
        // Groups that contacts push after all, and that a chord step would not do for.
        let working = case.working_groups(system);
        let stays = part.still(&working);
        let others: Vec<bool> = still.iter().zip(&stays).map(|(was, is)| !was || *is).collect();
        system.fibers.for_groups(&others, |group| group.linearize())?;
        still.iter_mut().zip(stays).for_each(|(still, stays)| *still &= stays);
        // What others do does not move those that have no contact.
        let pushed = before.iter().zip(&working).map(|(before, now)| before | now);
        let unmoved: Vec<bool> =
            still.iter().zip(pushed).map(|(still, on)| *still && !on).collect();
        let advance = |group: &mut FiberGroup<_>, own: Impulses| group.advance(own);
        let turns = system.fibers.with_impulses(&unmoved, case.pushes(), advance)?;
        system.push(case.pushes(), part.time, part.dt)?;
        case.turned(&turns);
        let turn = part.note_turns(&turns, &unmoved, &still);
        laps.lap(&mut self.times.rods);
        let dt = part.dt;
        let mean = part.mean(system, case);
        self.bend(system, case, mean, dt);
        let found = case.certificate(system, mean);
        case.set_error(self.tolerance(part.dt).error(&found));
        laps.lap(&mut self.times.laws);
        part.report.iterations += system.fibers.assembly().fibers().len();
        part.report.worst_iterations += 1;
        let report = &mut part.report.contact;
        report.iterations += one.iterations;
        report.solves += 1;
        report.residual = found.residual;
        report.normal_error = found.normal_error;
        report.slip_error = found.slip_error;
        Ok((turn, self.solver.tolerance().error(&one) <= 1.0))
    }

    /// Whether fibres have come deeper into each other than their contacts tell, by more than they
    /// may: a solution with these contacts would be found to be none.
    fn strays(
        &mut self,
        system: &CoupledSystem,
        part: &mut Substep,
        case: &ContactProblem,
    ) -> Result<bool, CollisionError> {
        let mut laps = PhaseTimer::start(self.stopwatch);
        let dt = part.dt;
        let near = case.near(system, part.mean(system, case), dt);
        let found = detection::gaps(&part.motion(system, &self.shapes), &near)?;
        laps.lap(&mut self.times.detection);
        let deeper =
            |(point, found): (&ContactPoint, f64)| point.gap.min(0.0) - found > self.depth();
        Ok(near.iter().zip(found).any(deeper))
    }

    /// An effort that need not be the last. What a film pulls is far more than what moves fibres:
    /// loose answers would fling them apart.
    pub(super) fn rough(&self, effort: ForcingTerm) -> ForcingTerm {
        if self.film.is_some() { ForcingTerm::LAST } else { self.of_use(effort) }
    }

    /// The effort with contacts that are new where fibres are so deep in each other, m. One by one
    /// an exact solution costs less than another iteration of Newton's method.
    pub(super) fn of_next_list(&self, depth: f64) -> ForcingTerm {
        if self.solver.is_one_by_one() {
            ForcingTerm::LAST
        } else {
            self.rough(ForcingTerm::where_off(depth / self.depth()))
        }
    }

    /// An effort as far as that is of use.
    fn of_use(&self, effort: ForcingTerm) -> ForcingTerm {
        let polished = self.settings.solver == ContactMethod::Polished;
        if polished { effort.polished() } else { effort }
    }

    /// How well the contacts of a step of `dt` seconds must be solved.
    pub(super) fn tolerance(&self, dt: f64) -> Tolerance {
        let ContactSettings { residual, slip, iterations, .. } = self.settings;
        Tolerance { residual, normal: 0.5 * self.depth() / dt, slip, iterations }
    }
}

fn largest(turns: &[f64]) -> f64 {
    turns.iter().copied().fold(0.0, f64::max)
}
