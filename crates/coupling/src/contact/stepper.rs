use super::adhesive_film::AdhesiveFilm;
use super::contact_work::ContactWork;
use super::detection::{self, ContactDetector};
use super::forcing_term::ForcingTerm;
use super::initial_overlaps;
use super::laws::ContactLaws;
use super::leaps::refuse_leaps;
use super::problem::{ContactProblem, ProblemWorkspace};
use super::substep::Substep;
use super::substep_failure::{SubstepFailure, lost};
use super::system::CoupledSystem;
use super::warm_start::WarmStart;
use super::warm_start::{
    CachedImpulse, ExpectedImpulses, bonds_within, cache_impulses, cached_impulses, match_cached,
};
use crate::contact_point::{ContactPoint, merged};
use crate::contact_report::Unresolved;
use crate::phase_times::Stopwatch;
use crate::phase_times::{ContactTimes, PhaseTimer};
use crate::{CouplingError, StepReport};
use nalgebra::Vector3;
use rapunzel_collision::{CollisionError, segment_radii};
use rapunzel_contact::{Admm, ContactSolver, Polished, Tolerance};
use rapunzel_scene::{Adhesion, ContactMethod, ContactSettings};

/// Most iterations of Newton's method with one list of contacts, and most lists.
const MOST_ITERATIONS: usize = 8;
const MOST_LISTS: usize = 9;
/// From this list on no contact is dropped: some would come and go for ever.
const PATIENCE: usize = 3;
/// Increments below this, rad, need not be taken.
const SMALL_TURN: f64 = 1e-4;
/// After one that is smaller than this the next is taken to be: it is of the order of the square.
/// Of a falling lock it was the square, and 190 times that at worst, where that was less than a
/// third of what may stay.
const LAST_TURN: f64 = 1e-3;
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
/// Gaps up to so many radii are listed.
const MARGIN: f64 = 0.5;
/// By how many radii the first list of a step, which is of where it is expected to lead, is wider
/// than the others.
const WIDE: f64 = 0.5;
/// Most halvings of a step.
const MOST_HALVINGS: u32 = 6;

/// Fibres with all contacts among them and with objects.
pub(super) struct ContactStepper {
    settings: ContactSettings,
    film: Option<AdhesiveFilm>,
    detector: ContactDetector,
    solver: ContactSolver,
    /// Radii of all segments, m.
    radii: Vec<f64>,
    /// The smallest radius of a segment, m.
    radius: f64,
    /// Bonds at the start of a run.
    bonds: Vec<CachedImpulse>,
    /// Contact points of the step before, whose memory the next list takes.
    touches: Vec<ContactPoint>,
    /// Workspace of the last contact problem.
    room: ProblemWorkspace,
    /// Time that phases of the step at hand have taken.
    times: ContactTimes,
    /// What touched in the last part.
    pub(super) memory: WarmStart,
    /// What tells how long phases take.
    pub(super) stopwatch: Option<Stopwatch>,
}

impl ContactStepper {
    /// Refuses a world that starts too deep in itself, and puts bonds where it touches itself.
    pub(super) fn new(
        settings: ContactSettings,
        system: &CoupledSystem,
    ) -> Result<Self, CouplingError> {
        let radii =
            segment_radii(system.fibers.assembly().layout(), system.fibers.assembly().radii());
        let radius = radii.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = radii.iter().copied().fold(0.0, f64::max);
        let film =
            settings.adhesion.map(|adhesion| AdhesiveFilm::new(adhesion, radius)).transpose()?;
        let film = film.flatten();
        let bonds = settings.adhesion.and_then(Adhesion::bonds);
        let of_film = || film.as_ref().map_or(0.0, AdhesiveFilm::reach);
        let range = bonds.map_or_else(of_film, |bonds| bonds.range);
        let detector =
            ContactDetector::new(MARGIN * largest + range, WIDE * largest, film.is_some())?;
        let solver = match settings.solver {
            ContactMethod::Splitting => ContactSolver::Splitting(Admm::new(Tolerance::EXACT)),
            ContactMethod::Polished => ContactSolver::Polished(Polished::new(Tolerance::EXACT)),
        };
        let mut stepper = Self {
            settings,
            film,
            detector,
            solver,
            radii,
            radius,
            bonds: Vec::new(),
            touches: Vec::new(),
            room: ProblemWorkspace::default(),
            times: ContactTimes::default(),
            memory: WarmStart::default(),
            stopwatch: None,
        };
        let depths = [radius, stepper.depth()];
        let touches =
            initial_overlaps::touches(system, &mut stepper.detector, &stepper.radii, depths)?;
        if let Some(bonds) = bonds {
            stepper.bonds = bonds_within(&touches, bonds.range);
        }
        Ok(stepper)
    }
}

impl ContactStepper {
    /// Takes the step in parts where it must. A part of the shortest length is taken as far as it
    /// has come, which the report tells.
    pub(super) fn step_in_substeps(
        &mut self,
        system: &mut CoupledSystem,
        dt: f64,
    ) -> Result<StepReport, CouplingError> {
        let start = system.start;
        refuse_leaps(system, dt)?;
        self.times = ContactTimes::default();
        let mut report =
            StepReport { fibers: system.fibers.assembly().fibers().len(), ..Default::default() };
        // In shortest parts, so that the last ends exactly.
        let whole = 1_u32 << MOST_HALVINGS;
        let (mut done, mut part) = (0, whole);
        while done < whole {
            let length = dt * f64::from(part) / f64::from(whole);
            let time = start + dt * f64::from(done) / f64::from(whole);
            match self.try_substep(system, time, length, part == 1) {
                Ok(one) => {
                    report.iterations += one.iterations;
                    report.worst_iterations = report.worst_iterations.max(one.worst_iterations);
                    report.contact.add(&one.contact);
                    done += part;
                    while part < whole && done.is_multiple_of(2 * part) {
                        part *= 2;
                    }
                }
                Err(SubstepFailure::Fatal(error)) if part == 1 || !lost(&error) => {
                    return Err(error);
                }
                Err(SubstepFailure::Rod(source)) if part == 1 => {
                    return Err(CouplingError::Step { time, source });
                }
                Err(SubstepFailure::Contacts(worst)) if part == 1 => {
                    return Err(CouplingError::Lost { time, dt: length, worst });
                }
                Err(_) => {
                    part /= 2;
                    report.halvings += 1;
                }
            }
        }
        report.contact_times = self.times;
        self.memory.report = report.contact;
        Ok(report)
    }

    /// Takes one part of a step, or leaves the world as it was. The `last` resort is taken as far
    /// as it comes, unless it leads nowhere or through a fibre.
    fn try_substep(
        &mut self,
        system: &mut CoupledSystem,
        time: f64,
        dt: f64,
        last: bool,
    ) -> Result<StepReport, SubstepFailure> {
        self.solver.forget();
        let mut part = Substep {
            time,
            dt,
            touches: std::mem::take(&mut self.touches),
            work: ContactWork::default(),
            report: StepReport::default(),
        };
        // It is forces that last: impulses grow with the step.
        let scale = self.memory.dt.map_or(0.0, |before| dt / before);
        let first = self.memory.dt.is_none();
        let bearing = std::mem::take(&mut self.memory.bearing);
        let mut known = if first { self.bonds.clone() } else { bearing };
        let solved =
            self.solve(system, &mut part, &ExpectedImpulses { known: &known, scale }, last);
        if solved.is_ok() {
            system.accept(time, dt);
            cache_impulses(&part.touches, &mut known);
        } else {
            system.abandon();
            if first {
                known.clear();
            }
        }
        self.memory.bearing = known;
        solved?;
        self.memory.dt = Some(dt);
        self.memory.work += part.work;
        part.report.contact.parts = 1;
        self.touches = part.touches;
        Ok(part.report)
    }

    fn solve(
        &mut self,
        system: &mut CoupledSystem,
        part: &mut Substep,
        expected: &ExpectedImpulses,
        last: bool,
    ) -> Result<(), SubstepFailure> {
        let (time, dt) = (part.time, part.dt);
        let mut laps = PhaseTimer::start(self.stopwatch);
        system.push(expected.pushes(), time, dt)?;
        system
            .fibers
            .with_impulses(expected.pushes(), |group, own| group.set_out(time, dt, own))?;
        laps.lap(&mut self.times.rods);
        self.list(system, part, expected)?;
        let mean = system.fibers.mean_velocities();
        let room = std::mem::take(&mut self.room);
        let mut case = self.case(system, part, expected, &mean, room)?;
        let mut laps = PhaseTimer::start(self.stopwatch);
        let start = case.certificate(system, &part.touches, &mean);
        laps.lap(&mut self.times.laws);
        drop(mean);
        let mut effort = self.rough(ForcingTerm::first(self.tolerance(dt).error(&start)));
        let mut worst_touch = None;
        for list in 0..MOST_LISTS {
            let solved = self.converge(system, part, &mut case, list, effort, last)?;
            let mut bearing = std::mem::take(&mut part.touches);
            case.give_impulses(&mut bearing);
            let deepest = self.look_at_end(system, part, &bearing)?;
            let mut laps = PhaseTimer::start(self.stopwatch);
            let mean = system.fibers.mean_velocities();
            part.work = case.work(system, &bearing, &mean);
            laps.lap(&mut self.times.laws);
            let report = &mut part.report.contact;
            (report.listed, report.active) = (case.contacts(), case.active());
            report.lists += 1;
            report.depth = deepest;
            worst_touch = Unresolved::deepest(time, &part.touches);
            if solved && deepest <= self.depth() {
                part.touches = bearing;
                // What a way leads through may leave no touch at its end.
                let through = self.detector.leads_through();
                // About a bend or each other, two that are fast may turn so far that a step drives
                // them.
                let errors = [self.depth() / dt, self.settings.slip];
                if through || case.drives(system, &part.touches, &mean, errors) {
                    worst_touch = worst_touch.or_else(|| worst(system, part, &case));
                    // No part is so short that fibres may go through each other.
                    if through || !last {
                        return Err(SubstepFailure::Contacts(worst_touch));
                    }
                    part.report.contact.miss(worst_touch);
                }
                if let Some(bonds) = self.settings.adhesion.and_then(Adhesion::bonds) {
                    let bounds = [bonds.strength, self.settings.slip];
                    case.tear(system, &mut part.touches, &mean, bounds)?;
                }
                self.room = case.into_workspace();
                return Ok(());
            }
            case.set_gaps(system, &mut bearing, &mean, dt);
            part.touches = merged(bearing, &part.touches, self.shallow(), list < PATIENCE);
            case = self.case(system, part, expected, &mean, case.into_workspace())?;
            effort = self.rough(ForcingTerm::where_off(deepest / self.depth()));
        }
        let worst_touch = worst_touch.or_else(|| worst(system, part, &case));
        if !last || self.detector.leads_through() {
            return Err(SubstepFailure::Contacts(worst_touch));
        }
        part.report.contact.miss(worst_touch);
        Ok(())
    }

    /// An effort that need not be the last. What a film pulls is far more than what moves fibres:
    /// loose answers would fling them apart.
    fn rough(&self, effort: ForcingTerm) -> ForcingTerm {
        if self.film.is_some() { ForcingTerm::LAST } else { self.of_use(effort) }
    }

    /// An effort as far as that is of use.
    fn of_use(&self, effort: ForcingTerm) -> ForcingTerm {
        let polished = self.settings.solver == ContactMethod::Polished;
        if polished { effort.polished() } else { effort }
    }

    /// How deep in each other things may be after a step, m: so little that a film does not tear by
    /// an error.
    fn depth(&self) -> f64 {
        let depth = self.settings.depth * 2.0 * self.radius;
        self.film.as_ref().map_or(depth, |film| depth.min(0.1 * film.reach()))
    }

    /// How deep may be what is not worth a contact of its own, m.
    fn shallow(&self) -> f64 {
        0.5 * self.depth()
    }

    /// Solves the step with the contacts of a case, of the list of this number, from this effort
    /// on. Tells whether rods and contacts are within their tolerances. Where all fly apart they
    /// are not listed again: what is swept then could be everything.
    fn converge(
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
            let mut laps = PhaseTimer::start(self.stopwatch);
            let own = largest(system.fibers.for_groups(|group| group.linearize())?);
            laps.lap(&mut self.times.rods);
            if solved && own < SMALL_TURN {
                return Ok(true);
            }
            let (increment, reached) = self.iterate(system, part, case, effort, patient)?;
            (turn, exact) = (increment, effort.is_last());
            // Fibres may be so entangled by where the step began that no impulses let them through.
            let left = case.error().unwrap_or(f64::INFINITY);
            if !reached && longer && !last && left > PROGRESS * error {
                return Err(SubstepFailure::Contacts(worst(system, part, case)));
            }
            longer = !reached;
            effort =
                if longer { effort.again(LONGER) } else { self.of_use(ForcingTerm::after(left)) };
        }
        if turn > LOST {
            Err(SubstepFailure::Contacts(worst(system, part, case)))
        } else {
            Ok(false)
        }
    }

    /// Whether fibres have come deeper into each other than their contacts tell, by more than they
    /// may: a solution with these contacts would be found to be none.
    fn strays(
        &mut self,
        system: &CoupledSystem,
        part: &Substep,
        case: &ContactProblem,
    ) -> Result<bool, CollisionError> {
        let mut laps = PhaseTimer::start(self.stopwatch);
        let mean = system.fibers.mean_velocities();
        let ends = part.ends(system, &mean);
        let near = case.near(system, &part.touches, &mean, part.dt);
        let found = detection::gaps(&part.motion(system, &self.radii, &ends), &near)?;
        laps.lap(&mut self.times.detection);
        let deeper =
            |(touch, found): (&ContactPoint, f64)| touch.gap.min(0.0) - found > self.depth();
        Ok(near.iter().zip(found).any(deeper))
    }

    /// The contacts of a part whose touches were listed where nodes have the given mean velocities.
    /// Their impulses act from now on and no others: some may have been expected of touches that
    /// are gone.
    fn case(
        &mut self,
        system: &mut CoupledSystem,
        part: &Substep,
        expected: &ExpectedImpulses,
        mean: &[Vector3<f64>],
        room: ProblemWorkspace,
    ) -> Result<ContactProblem, SubstepFailure> {
        let mut laps = PhaseTimer::start(self.stopwatch);
        let gravity = system.environment.gravity_at(part.time + 0.5 * part.dt).norm();
        let laws =
            ContactLaws::new(&self.settings, self.film.as_ref(), system.objects, gravity, part.dt);
        let gives = self.settings.compliance > 0.0;
        let before = if gives { cached_impulses(expected, &part.touches) } else { Vec::new() };
        let case = ContactProblem::new(system, &part.touches, mean, part.dt, &laws, before, room)?;
        laps.lap(&mut self.times.laws);
        let pushes = case.pushes(&part.touches);
        system.push(pushes.clone(), part.time, part.dt)?;
        system.fibers.with_impulses(pushes, |group, own| group.press(own))?;
        laps.lap(&mut self.times.rods);
        Ok(case)
    }

    /// How well the contacts of a step of `dt` seconds must be solved.
    fn tolerance(&self, dt: f64) -> Tolerance {
        let ContactSettings { residual, slip, iterations, .. } = self.settings;
        Tolerance { residual, normal: 0.5 * self.depth() / dt, slip, iterations }
    }

    /// One iteration of Newton's method, with the rods as they are linearised. Returns the largest
    /// increment, rad, and whether the contacts were solved as well as asked.
    fn iterate(
        &mut self,
        system: &mut CoupledSystem,
        part: &mut Substep,
        case: &mut ContactProblem,
        effort: ForcingTerm,
        patient: bool,
    ) -> Result<(f64, bool), SubstepFailure> {
        self.solver.set_tolerance(effort.of(&self.tolerance(part.dt)));
        let mut laps = PhaseTimer::start(self.stopwatch);
        let one = case.solve(system, &part.touches, &mut self.solver, patient)?;
        laps.lap(&mut self.times.solver);
        let pushes = case.pushes(&part.touches);
        let turns = system.fibers.with_impulses(pushes.clone(), |group, own| group.advance(own))?;
        system.push(pushes, part.time, part.dt)?;
        case.turned(&turns);
        let turn = largest(turns);
        laps.lap(&mut self.times.rods);
        let found = case.certificate(system, &part.touches, &system.fibers.mean_velocities());
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

    /// Lists the touches where the step leads, with the impulses expected of them.
    fn list(
        &mut self,
        system: &CoupledSystem,
        part: &mut Substep,
        expected: &ExpectedImpulses,
    ) -> Result<(), CollisionError> {
        let mut laps = PhaseTimer::start(self.stopwatch);
        let mut touches = std::mem::take(&mut part.touches);
        // Lists take much room: the velocities go before, and come again.
        let ends = part.ends(system, &system.fibers.mean_velocities());
        let motion = part.motion(system, &self.radii, &ends);
        self.detector.touches(&motion, system.objects, &mut touches)?;
        match_cached(expected, &mut touches);
        part.touches = touches;
        laps.lap(&mut self.times.detection);
        Ok(())
    }

    /// Lists those that overlap where the step has been solved to, with such touches. Returns by
    /// how much at most, m, where these do not give way.
    fn look_at_end(
        &mut self,
        system: &CoupledSystem,
        part: &mut Substep,
        bearing: &[ContactPoint],
    ) -> Result<f64, CollisionError> {
        let mut laps = PhaseTimer::start(self.stopwatch);
        let mut touches = Vec::new();
        let ends = part.ends(system, &system.fibers.mean_velocities());
        let motion = part.motion(system, &self.radii, &ends);
        let shallow = self.shallow();
        let mut deepest = self.detector.overlaps(&motion, system.objects, shallow, &mut touches)?;
        if self.settings.compliance > 0.0 {
            // What is not listed is no deeper.
            let mut known = Vec::new();
            cache_impulses(bearing, &mut known);
            let impulses =
                cached_impulses(&ExpectedImpulses { known: &known, scale: 1.0 }, &touches);
            let gives = self.settings.compliance / part.dt;
            let depth = |(touch, impulse): (&ContactPoint, Vector3<f64>)| {
                -touch.gap - gives * impulse.dot(&touch.normal)
            };
            let depths = touches.iter().zip(impulses).map(depth);
            deepest = depths.fold(deepest.min(shallow), f64::max);
        }
        part.touches = touches;
        laps.lap(&mut self.times.detection);
        Ok(deepest)
    }
}

/// The touch that is farthest from its law.
fn worst(system: &CoupledSystem, part: &Substep, case: &ContactProblem) -> Option<Unresolved> {
    let touch =
        &part.touches[case.worst(system, &part.touches, &system.fibers.mean_velocities())?];
    Some(Unresolved::new(part.time, touch))
}

fn largest(turns: Vec<f64>) -> f64 {
    turns.into_iter().fold(0.0, f64::max)
}
