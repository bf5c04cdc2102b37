use super::adhesive_film::AdhesiveFilm;
use super::ball_joints::{BallJoints, ContactJoints};
use super::detection::ContactDetector;
use super::forcing_term::ForcingTerm;
use super::initial_overlaps;
use super::leaps::refuse_leaps;
use super::problem::ProblemWorkspace;
use super::sections::SectionShapes;
use super::substep::Substep;
use super::substep_failure::{SubstepFailure, lost};
use super::system::CoupledSystem;
use super::warm_start::{CachedImpulse, ExpectedImpulses, WarmStart, bonds_within, cache_impulses};
use crate::contact_point::{ContactImpulse, ContactPoint};
use crate::contact_report::Unresolved;
use crate::merging::merged;
use crate::phase_times::{ContactTimes, PhaseTimer, Stopwatch};
use crate::regrouping::GroupClasses;
use crate::{CouplingError, FiberGroup, StepReport, TimeInterval};
use nalgebra::Vector3;
use rapunzel_contact::{Adaptive, ContactSolver, Polished, Tolerance};
use rapunzel_rod_dynamic::{Impulses, StaggeredBatch};
use rapunzel_scene::{Adhesion, ContactMethod, ContactSettings};

/// Most lists of contacts in a substep.
const MOST_LISTS: usize = 9;
/// From this list on no contact is dropped: some would come and go for ever.
pub(super) const PATIENCE: usize = 3;
/// Gaps up to so many radii are listed.
const MARGIN: f64 = 0.5;
/// Radii by which the first list of a step, of where it is expected to lead, is wider.
const WIDE: f64 = 0.5;
/// Part of the slip that contacts may have at which the ends of segments may move that are not in
/// balance.
const MISSLIP: f64 = 0.1;
/// Most halvings of a step.
const MOST_HALVINGS: u32 = 6;

/// Fibres with all contacts among them and with objects.
pub(super) struct ContactStepper {
    pub(super) settings: ContactSettings,
    pub(super) film: Option<AdhesiveFilm>,
    pub(super) detector: ContactDetector,
    pub(super) solver: ContactSolver,
    /// Sections of all segments.
    pub(super) shapes: SectionShapes,
    /// Groups among which fibres may move.
    classes: GroupClasses,
    /// The smallest radius of a circle with the area of a section, m.
    radius: f64,
    /// Mass of a segment of the lightest fibre, kg.
    pub(super) segment_mass: f64,
    /// How fast segments may turn that are not in balance, rad/s.
    misspin: f64,
    /// Bonds at the start of a run.
    bonds: Vec<CachedImpulse>,
    /// Contact points of the last substep, whose memory the next list takes.
    pub(super) points: Vec<ContactPoint>,
    /// Workspace of the last contact problem.
    pub(super) room: ProblemWorkspace,
    /// Time that phases of the step at hand have taken.
    pub(super) times: ContactTimes,
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
        joints: ContactJoints,
    ) -> Result<Self, CouplingError> {
        let assembly = system.fibers.assembly();
        let segments = assembly.fibers().iter().map(|f| f.mass() / f.segments() as f64);
        let segment_mass = segments.fold(f64::INFINITY, f64::min);
        let lengths = assembly.fibers().iter().flat_map(|f| f.segment_lengths());
        let misspin = MISSLIP * settings.slip / lengths.copied().fold(0.0, f64::max);
        let shapes = SectionShapes::new(assembly);
        let radius = assembly.radii().iter().copied().fold(f64::INFINITY, f64::min);
        let largest = shapes.radii.iter().copied().fold(0.0, f64::max);
        let film =
            settings.adhesion.map(|adhesion| AdhesiveFilm::new(adhesion, radius)).transpose()?;
        let film = film.flatten();
        let bonds = settings.adhesion.and_then(Adhesion::bonds);
        let of_film = || film.as_ref().map_or(0.0, AdhesiveFilm::reach);
        let range = bonds.map_or_else(of_film, |bonds| bonds.range);
        let mut detector =
            ContactDetector::new(MARGIN * largest + range, WIDE * largest, film.is_some())?;
        detector.joints = BallJoints::new(joints, system)?;
        let solver = match settings.solver {
            ContactMethod::Splitting => ContactSolver::Adaptive(Adaptive::new(Tolerance::EXACT)),
            ContactMethod::Polished => ContactSolver::Polished(Polished::new(Tolerance::EXACT)),
        };
        let mut stepper = Self {
            settings,
            film,
            detector,
            solver,
            shapes,
            classes: GroupClasses::new(system.fibers),
            radius,
            segment_mass,
            misspin,
            bonds: Vec::new(),
            points: Vec::new(),
            room: ProblemWorkspace::default(),
            times: ContactTimes::default(),
            memory: WarmStart {
                joints: vec![Vector3::zeros(); joints.impulses()],
                ..WarmStart::default()
            },
            stopwatch: None,
        };
        let held = stepper.shallow();
        let points = initial_overlaps::contact_points(
            system,
            &mut stepper.detector,
            &stepper.shapes,
            radius,
            held,
        )?;
        if let Some(bonds) = bonds {
            stepper.bonds = bonds_within(&points, bonds.range);
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

    /// Begins the search for the impulses of the first step at those that others remember, of
    /// fibres that have these numbers here. Where bonds hold, it begins at these.
    pub(super) fn expect(&mut self, others: &WarmStart, numbers: &[u32]) {
        if self.bonds.is_empty() {
            let joints = std::mem::take(&mut self.memory.joints);
            self.memory = WarmStart { joints, ..others.renumbered(numbers) };
        }
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
        let mut part = Substep::new(time, dt, system, self.misspin);
        // It is forces that last: impulses grow with the step.
        let scale = self.memory.dt.map_or(0.0, |before| dt / before);
        let first = self.memory.dt.is_none();
        let bearing = std::mem::take(&mut self.memory.bearing);
        let mut known = if first { self.bonds.clone() } else { bearing };
        let joints = self.memory.joints.clone();
        let expected = ExpectedImpulses { known: &known, scale };
        self.memory.joints.iter_mut().for_each(|own| *own *= scale);
        let solved = self.solve(system, &mut part, &expected, last);
        match &solved {
            Ok(()) => {
                let junctions = &self.detector.joints.junctions;
                let works = junctions.works(system.fibers, part.work_of_couples, dt);
                // Before the step is accepted: those that fly need to know how they speed up.
                system.take_off(&part.touching);
                system.accept(time, dt, &works);
                self.regroup(system, &part.touching)?;
                cache_impulses(&self.points, &mut known);
            }
            Err(_) => {
                system.abandon();
                self.memory.joints = joints;
                if first {
                    known.clear();
                }
            }
        }
        self.memory.bearing = known;
        solved?;
        self.memory.dt = Some(dt);
        self.memory.work += part.work;
        part.report.contact.parts = 1;
        Ok(part.report)
    }

    /// Lets fibres that touch something move side by side, so that few groups are solved with
    /// contacts.
    fn regroup(
        &mut self,
        system: &mut CoupledSystem,
        touching: &[bool],
    ) -> Result<(), SubstepFailure> {
        let mut laps = PhaseTimer::start(self.stopwatch);
        if let Some(order) = self.classes.with_busy_together(system.fibers, touching) {
            let arranged = system.fibers.arrange(&order.concat());
            arranged.map_err(|error| SubstepFailure::Fatal(error.into()))?;
        }
        laps.lap(&mut self.times.rods);
        Ok(())
    }

    /// Solves a substep: lists contacts where it is expected to lead, solves them together with the
    /// rods, and lists anew where that leads, until none is missing. Its contact points are then
    /// the stepper's.
    fn solve(
        &mut self,
        system: &mut CoupledSystem,
        part: &mut Substep,
        expected: &ExpectedImpulses,
        last: bool,
    ) -> Result<(), SubstepFailure> {
        let (time, dt) = (part.time, part.dt);
        self.detector.hide(system.in_nozzles(time + dt));
        self.detector.joints.junctions.set_out(system.fibers);
        let joints = self.detector.joints.pushes(system, &self.memory.joints);
        let pushes = || expected.pushes().chain(joints.iter().copied());
        system.push(pushes(), time, dt)?;
        self.set_out(system, part, pushes(), &part.all())?;
        let points = self.list(system, part, expected, None)?;
        let points = self.land(system, part, expected, points)?;
        let mut case = self.case(system, part, expected, points)?;
        let mut laps = PhaseTimer::start(self.stopwatch);
        let start = case.certificate(system, part.mean(system, &case));
        laps.lap(&mut self.times.laws);
        let mut effort = self.rough(ForcingTerm::first(self.tolerance(dt).error(&start)));
        let mut worst_touch = None;
        let mut through = false;
        for list in 0..MOST_LISTS {
            let solved = self.converge(system, part, &mut case, list, effort, last)?;
            self.memory.joints = case.give_impulses();
            let found = self.look_at_end(system, part, case.points())?;
            through = found.through;
            let mut laps = PhaseTimer::start(self.stopwatch);
            part.note_work(system, &case, self.settings.slip);
            laps.lap(&mut self.times.laws);
            let report = &mut part.report.contact;
            (report.listed, report.active) = (case.points().len(), case.active());
            report.lists += 1;
            report.depth = found.deepest;
            worst_touch = Unresolved::deepest(time, &found.points);
            if solved && found.deepest <= self.depth() {
                // About a bend or each other, two that are fast may turn so far that a step drives
                // them.
                let (repair, slip) = (self.depth() / dt, self.settings.slip);
                if through || case.drives(system, part.mean(system, &case), repair, slip) {
                    worst_touch = worst_touch.or_else(|| case.worst(system, time));
                    // No part is so short that fibres may go through each other.
                    if through || !last {
                        return Err(SubstepFailure::Contacts(worst_touch));
                    }
                    part.report.contact.miss(worst_touch);
                }
                if let Some(bonds) = self.settings.adhesion.and_then(Adhesion::bonds) {
                    case.tear(system, part.mean(system, &case), bonds.strength, slip)?;
                }
                let creep = case.note_drifts(system, part.mean(system, &case), dt, slip);
                part.report.contact.creep = creep;
                if self.settings.rolling_resistance > 0.0 {
                    let step = TimeInterval { start: time, length: dt };
                    let resistance = self.settings.rolling_resistance;
                    case.lean(system, part.mean(system, &case), step, resistance);
                }
                (self.points, self.room) = case.into_parts();
                return Ok(());
            }
            case.set_gaps(system, part.mean(system, &case), dt);
            let (bearing, room) = case.into_parts();
            let points = merged(bearing, &found.points, self.shallow(), list < PATIENCE);
            self.room = room;
            let points = self.land(system, part, expected, points)?;
            case = self.case(system, part, expected, points)?;
            effort = self.of_next_list(found.deepest);
        }
        let worst_touch = worst_touch.or_else(|| case.worst(system, time));
        if !last || through {
            return Err(SubstepFailure::Contacts(worst_touch));
        }
        part.report.contact.miss(worst_touch);
        self.points = case.into_parts().0;
        Ok(())
    }

    /// Lets fibres that flew bear contact points: their groups set out anew with the impulses of
    /// these, and their contact points are listed again, until none flies that has any.
    fn land(
        &mut self,
        system: &mut CoupledSystem,
        part: &mut Substep,
        expected: &ExpectedImpulses,
        mut points: Vec<ContactPoint>,
    ) -> Result<Vec<ContactPoint>, SubstepFailure> {
        while let Some(others) = system.land(&mut part.touching, &points, &self.detector.joints) {
            let joints = self.detector.joints.pushes(system, &self.memory.joints);
            let bearing = points.iter().filter(|point| point.impulse != Vector3::zeros());
            let pushes = bearing.map(|point| point.push(point.impulse)).chain(joints);
            self.set_out(system, part, pushes, &others)?;
            points = self.list_moved(system, part, expected, points, &others)?;
        }
        Ok(points)
    }

    /// Lets groups set out on a substep with some impulses, anew where they have done so already,
    /// but `others`.
    fn set_out(
        &mut self,
        system: &mut CoupledSystem,
        part: &mut Substep,
        pushes: impl Iterator<Item = ContactImpulse> + Clone,
        others: &[bool],
    ) -> Result<(), SubstepFailure> {
        let mut laps = PhaseTimer::start(self.stopwatch);
        let (time, dt) = (part.time, part.dt);
        let set_out = |group: &mut FiberGroup<StaggeredBatch>, own: Impulses| {
            group.batch.abandon();
            group.set_out(time, dt, own)
        };
        let turns = system.fibers.with_impulses(others, pushes, set_out)?;
        part.note_set_out(&turns, others);
        laps.lap(&mut self.times.rods);
        Ok(())
    }

    /// How deep in each other things may be after a step, m: so little that a film does not tear by
    /// an error.
    pub(super) fn depth(&self) -> f64 {
        let depth = self.settings.depth * 2.0 * self.radius;
        self.film.as_ref().map_or(depth, |film| depth.min(0.1 * film.reach()))
    }

    /// How deep may be what is not worth a contact of its own, m.
    pub(super) fn shallow(&self) -> f64 {
        0.5 * self.depth()
    }
}
