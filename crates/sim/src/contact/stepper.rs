use super::case::Case;
use super::detect::{Detector, Motion};
use super::memory::{Remembered, recall, remember};
use super::object::Object;
use super::report::Unresolved;
use super::touch::{Partner, Touch};
use crate::scene::{ContactSettings, Friction};
use crate::{SimError, StepReport, Stepper, World};
use nalgebra::{Point3, Vector3};
use rapunzel_collision::{CollisionError, segment_radii};
use rapunzel_contact::{Admm, ContactError, Tolerance};
use rapunzel_rod_dynamic::StepError;

/// Most iterations of Newton's method with one list of contacts, and most lists.
const MOST_ITERATIONS: usize = 8;
const MOST_LISTS: usize = 9;
/// Increments below this, rad, end Newton's method: what is left is of the order of their square.
const SMALL_TURN: f64 = 1e-4;
/// By how many radii the second list is wider than the first, at most.
const WIDEST: f64 = 2.0;
/// How deep in each other things may be at the start, in radii: steps push them apart.
const OVERLAP: f64 = 0.2;
/// A step in which nothing moves, s.
const INSTANT: f64 = 1e-12;
/// Most halvings of a step.
const MOST_HALVINGS: u32 = 6;

/// Fibres with all contacts among them and with objects.
pub(crate) struct Touching {
    settings: ContactSettings,
    detector: Detector,
    solver: Admm,
    /// Of all segments, m.
    radii: Vec<f64>,
    /// The smallest, m.
    radius: f64,
}

/// Why a part of a step was not taken.
enum Cut {
    /// A rod did not converge.
    Rod(StepError),
    /// Contacts did not converge.
    Contacts,
    /// Shorter parts will not help.
    Fatal(SimError),
}

impl From<CollisionError> for Cut {
    fn from(error: CollisionError) -> Self {
        Self::Fatal(error.into())
    }
}

impl From<ContactError> for Cut {
    fn from(error: ContactError) -> Self {
        Self::Fatal(error.into())
    }
}

impl From<StepError> for Cut {
    fn from(error: StepError) -> Self {
        Self::Rod(error)
    }
}

/// The part of a step at hand.
struct Part {
    /// Its start and length, s.
    time: f64,
    dt: f64,
    /// Positions of all nodes at its start.
    start: Vec<Point3<f64>>,
    /// Mean velocities of all nodes when the touches were listed.
    mean: Vec<Vector3<f64>>,
    touches: Vec<Touch>,
    report: StepReport,
}

impl Touching {
    pub(crate) fn new(settings: ContactSettings, world: &World) -> Result<Self, SimError> {
        let radii = segment_radii(world.assembly().layout(), world.assembly().radii());
        let radius = radii.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = radii.iter().copied().fold(0.0, f64::max);
        let detector = Detector::new(largest, WIDEST * largest)?;
        let solver = Admm::new(Tolerance::EXACT);
        let mut touching = Self { settings, detector, solver, radii, radius };
        touching.refuse_overlaps(world)?;
        Ok(touching)
    }

    /// Refuses a world that starts deeper in itself than a step would leave it.
    fn refuse_overlaps(&mut self, world: &World) -> Result<(), SimError> {
        let start = world.positions();
        let motion = Motion {
            layout: world.assembly().layout(),
            radii: &self.radii,
            start: &start,
            end: &start,
            time: world.time(),
            dt: INSTANT,
        };
        let mut touches = Vec::new();
        self.detector.touches(&motion, &world.objects, 0.0, &mut touches)?;
        let deepest = touches.iter().min_by(|a, b| a.gap.total_cmp(&b.gap));
        match deepest {
            Some(touch) if touch.gap < -OVERLAP * self.radius => Err(SimError::Overlap {
                fiber: touch.fiber as usize,
                segment: touch.segments[0] as usize,
                other: touch.partner.to_string(),
                depth: -touch.gap,
            }),
            _ => Ok(()),
        }
    }
}

impl Stepper for Touching {
    /// Takes the step in parts where it must. A part of the shortest length is taken as far as it
    /// has come, which the report tells.
    fn step(&mut self, world: &mut World, dt: f64) -> Result<StepReport, SimError> {
        let start = world.time();
        refuse_leaps(world, dt)?;
        let mut report =
            StepReport { fibers: world.assembly().fibers().len(), ..Default::default() };
        // In shortest parts, so that the last ends exactly.
        let whole = 1_u32 << MOST_HALVINGS;
        let (mut done, mut part) = (0, whole);
        while done < whole {
            let length = dt * f64::from(part) / f64::from(whole);
            let time = start + dt * f64::from(done) / f64::from(whole);
            match self.take(world, time, length, part == 1) {
                Ok(one) => {
                    report.iterations += one.iterations;
                    report.worst_iterations = report.worst_iterations.max(one.worst_iterations);
                    report.contact.add(&one.contact);
                    done += part;
                    while part < whole && done.is_multiple_of(2 * part) {
                        part *= 2;
                    }
                }
                Err(Cut::Fatal(error)) if part == 1 || !lost(&error) => return Err(error),
                Err(Cut::Rod(source)) if part == 1 => return Err(SimError::Step { time, source }),
                Err(_) => {
                    part /= 2;
                    report.halvings += 1;
                }
            }
        }
        world.advance_clock(dt);
        Ok(report)
    }
}

impl Touching {
    /// Takes one part of a step, or leaves the world as it was. The `last` resort is taken as far
    /// as it comes.
    fn take(
        &mut self,
        world: &mut World,
        time: f64,
        dt: f64,
        last: bool,
    ) -> Result<StepReport, Cut> {
        let start = world.positions();
        let report = StepReport::default();
        let mut part = Part { time, dt, start, mean: Vec::new(), touches: Vec::new(), report };
        // It is forces that last: impulses grow with the step.
        let scale = world.contacts.dt.map_or(0.0, |before| dt / before);
        let mut expected = world.contacts.bearing.clone();
        expected.iter_mut().for_each(|one| one.impulse *= scale);
        let solved = self.solve(world, &mut part, &expected, last);
        if let Err(cut) = solved {
            world.abandon();
            return Err(cut);
        }
        world.accept();
        world.contacts.bearing = remember(&part.touches);
        world.contacts.dt = Some(dt);
        part.report.contact.parts = 1;
        Ok(part.report)
    }

    fn solve(
        &mut self,
        world: &mut World,
        part: &mut Part,
        expected: &[Remembered],
        last: bool,
    ) -> Result<(), Cut> {
        let (time, dt) = (part.time, part.dt);
        let touches: Vec<_> = expected.iter().map(Remembered::touch).collect();
        let impulses = world.impulses(&touches);
        world.push(&touches, time, dt)?;
        world.with_impulses(&impulses, |group, own| group.set_out(time, dt, own))?;
        let depth = self.settings.depth * 2.0 * self.radius;
        self.list(world, part, expected, 0.0)?;
        for list in 0..MOST_LISTS {
            let settings = &self.settings;
            let objects = &world.objects;
            let curve = |touch: &Touch| friction(settings, objects, touch).of(touch);
            let mut case = Case::new(world, &part.touches, &part.mean, dt, curve)?;
            // The first list is that of a guess: it is soon looked at again.
            let most = if list == 0 { 1 } else { MOST_ITERATIONS };
            let solved = self.iterate(world, part, &mut case, list, most)?;
            let mut bearing = std::mem::take(&mut part.touches);
            // What has moved far since it was listed may move as far again.
            let before = std::mem::take(&mut part.mean);
            let mean = world.mean_velocities();
            let moved = before.iter().zip(&mean).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            let more = if list == 0 { (moved * dt).min(WIDEST * self.radius) } else { 0.0 };
            self.list(world, part, &remember(&bearing), more)?;
            let deepest = part.touches.iter().map(|touch| -touch.gap).fold(0.0, f64::max);
            let report = &mut part.report.contact;
            (report.listed, report.active) = (case.contacts(), case.active());
            report.lists += 1;
            report.depth = deepest;
            if solved && deepest <= depth {
                part.touches = bearing;
                return Ok(());
            }
            if list + 1 == MOST_LISTS {
                report.unresolved = 1;
                report.first_unresolved = worst(time, &part.touches);
                part.touches = bearing;
            } else if list > 0 {
                case.give_gaps(world, &mean, dt, &mut bearing);
                part.touches = merged(bearing, &part.touches, 0.5 * depth);
            }
        }
        if last { Ok(()) } else { Err(Cut::Contacts) }
    }

    /// Solves the step with the contacts of a case, by at most so many iterations of Newton's
    /// method. Tells whether rods and contacts are within their tolerances.
    fn iterate(
        &mut self,
        world: &mut World,
        part: &mut Part,
        case: &mut Case,
        list: usize,
        most: usize,
    ) -> Result<bool, Cut> {
        let depth = self.settings.depth * 2.0 * self.radius;
        for iteration in 0..most {
            world.for_groups(|group| group.linearize())?;
            self.solver.tolerance = self.tolerance(list, iteration, depth / part.dt);
            let one = case.solve(world, &mut self.solver)?;
            case.give_impulses(&mut part.touches);
            let impulses = world.impulses(&part.touches);
            let turns = world.with_impulses(&impulses, |group, own| group.advance(own))?;
            world.push(&part.touches, part.time, part.dt)?;
            let turn = turns.into_iter().fold(0.0, f64::max);
            let found = case.certificate(world, &world.mean_velocities());
            part.report.iterations += world.assembly().fibers().len();
            part.report.worst_iterations += 1;
            let report = &mut part.report.contact;
            report.iterations += one.iterations;
            report.solves += 1;
            report.residual = found.residual;
            report.normal_error = found.normal_error;
            report.slip_error = found.slip_error;
            if turn < SMALL_TURN
                && found.residual <= self.settings.residual
                && found.slip_error <= self.settings.slip
                && found.normal_error * part.dt <= depth
            {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// How well the contacts are solved in an iteration of Newton's method: the first ones are not
    /// worth exact answers.
    fn tolerance(&self, list: usize, iteration: usize, normal: f64) -> Tolerance {
        let (slack, most) = match (list, iteration) {
            (0, _) => (100.0, 30),
            (_, 0) => (30.0, 60),
            (_, 1) => (3.0, 120),
            _ => (1.0, usize::MAX),
        };
        let slack = 0.5 * slack;
        Tolerance {
            residual: slack * self.settings.residual,
            normal: slack * normal,
            slip: slack * self.settings.slip,
            iterations: most.min(self.settings.iterations),
        }
    }

    /// Lists the touches where the step has been solved to, with the impulses expected of them.
    fn list(
        &mut self,
        world: &World,
        part: &mut Part,
        expected: &[Remembered],
        more: f64,
    ) -> Result<(), CollisionError> {
        part.mean = world.mean_velocities();
        let end: Vec<_> = part.start.iter().zip(&part.mean).map(|(x, v)| x + v * part.dt).collect();
        let motion = Motion {
            layout: world.assembly().layout(),
            radii: &self.radii,
            start: &part.start,
            end: &end,
            time: part.time,
            dt: part.dt,
        };
        self.detector.touches(&motion, &world.objects, more, &mut part.touches)?;
        recall(expected, &mut part.touches);
        Ok(())
    }
}

/// Refuses a step of `dt`, s, in which an object would jump over fibres.
fn refuse_leaps(world: &World, dt: f64) -> Result<(), SimError> {
    let segments = world.assembly().fibers().iter().map(|f| f.length() / f.segments() as f64);
    let (segment, time) = (segments.fold(f64::INFINITY, f64::min), world.time());
    let gravity = world.gravity_at(time + 0.5 * dt);
    for (object, one) in world.objects.iter().enumerate() {
        let [way, most] = one.leap([time, dt], &gravity, segment)?;
        if way > most {
            return Err(SimError::Leap { object, time, way, most, dt: dt * most / way });
        }
    }
    Ok(())
}

/// The friction of a touch.
fn friction(settings: &ContactSettings, objects: &[Object], touch: &Touch) -> Friction {
    let own = match touch.partner {
        Partner::Object(object) => objects[object as usize].friction,
        Partner::Fiber(_) => None,
    };
    own.unwrap_or(settings.friction)
}

/// Whether rods have gone nowhere, which a shorter part of a step may spare them.
fn lost(error: &SimError) -> bool {
    matches!(error, SimError::Collision(CollisionError::Position { .. }))
}

/// Where the deepest of some touches is.
fn worst(time: f64, touches: &[Touch]) -> Option<Unresolved> {
    let deepest = touches.iter().min_by(|a, b| a.gap.total_cmp(&b.gap))?;
    Some(Unresolved {
        time,
        fiber: deepest.fiber as usize,
        segment: deepest.segments[0] as usize,
        partner: deepest.partner,
        depth: -deepest.gap,
    })
}

/// The touches of a list, with those of another in place of theirs, or beside them, that are deeper
/// than `depth`.
fn merged(mut list: Vec<Touch>, other: &[Touch], depth: f64) -> Vec<Touch> {
    let old = list.len();
    for deep in other.iter().filter(|touch| touch.gap < -depth) {
        let pair = (deep.fiber, deep.partner);
        let start = list[..old].partition_point(|touch| (touch.fiber, touch.partner) < pair);
        let known = list[start..old]
            .iter_mut()
            .take_while(|touch| (touch.fiber, touch.partner) == pair)
            .find(|touch| touch.near(deep));
        match known {
            Some(touch) => *touch = Touch { impulse: touch.impulse, ..*deep },
            None => list.push(Touch { impulse: Vector3::zeros(), ..*deep }),
        }
    }
    list.sort_by(Touch::order);
    list
}
