//! Fibres that touch: the coupling of implicit rods with nonsmooth contact.
//!
//! A step of all fibres is solved together with the impulses of all contacts:
//!
//! 1. the rods solve their step with the impulses that the step before leads to expect;
//! 2. touches are found at the end of that step, as well as on the way there;
//! 3. the impulses are corrected, with the rods' responses linearised where they are;
//! 4. the rods solve their step again, and 2 to 4 repeat until the law holds where they really are.
//!
//! A step that does not end so is taken in halves.

mod body;
mod detect;
mod memory;
mod object;
mod touch;

pub(crate) use memory::Remembered;
pub(crate) use object::Object;

use crate::group::Group;
use crate::scene::ContactSettings;
use crate::{SimError, StepReport, Stepper, World};
use body::Fibers;
use detect::{Detector, Motion};
use memory::{recall, remember};
use rapunzel_collision::segment_radii;
use nalgebra::{Matrix3, Point3, Vector3};
use rapunzel_contact::{
    Admm, Body, Contact, ContactError, LimitCurve, Report, Solver, Tolerance, report,
};
use rapunzel_rod_dynamic::{Point, StepError};
use rayon::prelude::*;
use touch::{Partner, Touch};

/// What the contacts of a step were and cost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ContactReport {
    /// Contacts that were listed, and that bore something, in the last solve.
    pub listed: usize,
    /// Contacts that bore something.
    pub active: usize,
    /// Iterations of the contact solver.
    pub iterations: usize,
    /// Solves, one of them for the first.
    pub solves: usize,
    /// In how many parts the step was taken.
    pub parts: usize,
    /// Coulomb residual where the fibres really are.
    pub residual: f64,
    /// Largest error of a normal velocity, m/s.
    pub normal_error: f64,
    /// Largest slip of a contact that sticks, m/s.
    pub slip_error: f64,
    /// Least gap after the step, m; positive if nothing touches.
    pub gap: f64,
}

impl ContactReport {
    /// Adds another part of the step: counts are summed, of errors the largest stays.
    pub(crate) fn add(&mut self, other: &Self) {
        self.listed = self.listed.max(other.listed);
        self.active = self.active.max(other.active);
        self.iterations += other.iterations;
        self.solves += other.solves;
        self.parts += other.parts;
        self.residual = self.residual.max(other.residual);
        self.normal_error = self.normal_error.max(other.normal_error);
        self.slip_error = self.slip_error.max(other.slip_error);
        self.gap = self.gap.min(other.gap);
    }
}

/// Fibres with all contacts among them and with objects.
pub(crate) struct Touching {
    settings: ContactSettings,
    objects: Vec<Object>,
    detector: Detector,
    solver: Admm,
    /// Of all segments.
    radii: Vec<f64>,
    /// The smallest.
    radius: f64,
}

/// A step that must be taken in parts.
enum Cut {
    /// A rod did not converge.
    Rod(StepError),
    /// Something passed through something.
    Depth,
    Fatal(SimError),
}

/// By how many radii the list of contacts is widened at most.
const WIDEST: f64 = 2.0;
/// Most iterations of Newton's method with one list of contacts, and most lists.
const MOST_ITERATIONS: usize = 8;
const MOST_ROUNDS: usize = 8;
/// Increments below this, rad, end it: the error left is of the order of their square.
const SMALL_TURN: f64 = 1e-4;
/// Most halvings of a step.
const MOST_HALVINGS: u32 = 6;

impl Touching {
    pub(crate) fn new(
        settings: ContactSettings,
        objects: Vec<Object>,
        world: &World,
    ) -> Result<Self, SimError> {
        let radii = segment_radii(world.assembly().layout(), world.assembly().radii());
        let radius = radii.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = radii.iter().copied().fold(0.0, f64::max);
        let detector = Detector::new(largest)?;
        let mut solver = Admm::new(Tolerance::EXACT);
        let env = |k: &str, d: f64| std::env::var(k).ok().and_then(|v| v.parse().ok()).unwrap_or(d);
        solver.weight = env("RZ_K", 1.0);
        solver.relaxation = env("RZ_A", 1.6);
        solver.memory = env("RZ_M", 6.0) as usize;
        Ok(Self { settings, objects, detector, solver, radii, radius })
    }
}

/// Everything about the step at hand, in the order of the assembly.
struct Attempt {
    start: Vec<Point3<f64>>,
    end: Vec<Point3<f64>>,
    /// Mean velocities of the nodes.
    mean: Vec<Vector3<f64>>,
    touches: Vec<Touch>,
    report: StepReport,
}

impl Stepper for Touching {
    fn step(&mut self, world: &mut World, dt: f64) -> Result<StepReport, SimError> {
        let time = world.time();
        let mut report = StepReport::default();
        let (mut done, mut part) = (0_u32, 1_u32 << MOST_HALVINGS);
        let whole = f64::from(part);
        while f64::from(done) < whole {
            let length = dt * f64::from(part) / whole;
            let at = time + dt * f64::from(done) / whole;
            match self.attempt(world, at, length, part == 1) {
                Ok(one) => {
                    done += part;
                    report.add(&one);
                    report.contact.parts += 1;
                    // Room for longer parts again, as far as they end together with the step.
                    while part < 1 << MOST_HALVINGS && done.is_multiple_of(2 * part) {
                        part *= 2;
                    }
                }
                Err(Cut::Fatal(error)) => return Err(error),
                Err(Cut::Rod(source)) if part == 1 => {
                    return Err(SimError::Step { time: at, source });
                }
                Err(_) => part /= 2,
            }
        }
        world.advance_clock(dt);
        Ok(report)
    }
}

impl Touching {
    /// Takes one part of a step, or leaves the world as it was. The `last` resort takes what it
    /// has.
    fn attempt(
        &mut self,
        world: &mut World,
        time: f64,
        dt: f64,
        last: bool,
    ) -> Result<StepReport, Cut> {
        let mut attempt = Attempt {
            start: world.positions(),
            end: Vec::new(),
            mean: Vec::new(),
            touches: Vec::new(),
            report: StepReport::default(),
        };
        // Forces last, impulses are proportional to the step.
        let scale = world.contact_dt.map_or(1.0, |before| dt / before);
        let mut expected = world.contacts.clone();
        expected.iter_mut().for_each(|one| one.impulse *= scale);
        let mut impulses = vec![Vector3::zeros(); attempt.start.len()];
        for one in &expected {
            let partner = match one.partner {
                Partner::Fiber(fiber) => Some(fiber),
                Partner::Object(_) => None,
            };
            world.add_impulse(&mut impulses, one.fiber, one.at[0], &one.impulse);
            if let Some(partner) = partner {
                world.add_impulse(&mut impulses, partner, one.at[1], &-one.impulse);
            }
        }
        let set_out = world.for_groups(|group, own| group.set_out(time, dt, own), &impulses);
        let result = set_out
            .map_err(Cut::Rod)
            .and_then(|_| self.settle(world, &mut attempt, &expected, [time, dt], last));
        if let Err(cut) = result {
            world.abandon();
            return Err(cut);
        }
        world.accept();
        world.contacts = remember(&attempt.touches);
        world.contact_dt = Some(dt);
        Ok(attempt.report)
    }

    /// Solves the step by Newton's method, in which every iteration solves all contacts. Their
    /// places and normals are those of an iterate: once the step is solved with them, it is looked
    /// at where the fibres really are, and if they are too deep in each other, the contacts are
    /// listed anew.
    fn settle(
        &mut self,
        world: &mut World,
        attempt: &mut Attempt,
        expected: &[Remembered],
        [time, dt]: [f64; 2],
        last: bool,
    ) -> Result<(), Cut> {
        let depth = self.settings.depth * 2.0 * self.radius;
        self.detect(world, attempt, expected, [time, dt], 0.0)?;
        let curve = self.settings.friction.limit_curve();
        for round in 0.. {
            let mut case = Case::new(world, &curve, attempt, dt);
            // The first list is that of a guess: what follows from it is looked at again at once.
            let most = if round == 0 { 1 } else { MOST_ITERATIONS };
            let mut solved = false;
            for iteration in 0..most {
                world.for_groups(|group, _| group.linearize(), &[]).map_err(Cut::Rod)?;
                case.linear = world.at_points(&case.points, &world.velocities(true));
                // Newton's first iterations are not worth exact answers.
                let slack = if round == 0 { 30.0 } else { (10.0 * 0.1_f64.powi(iteration as i32)).max(1.0) };
                self.solver.tolerance = Tolerance {
                    residual: 0.5 * slack * self.settings.residual,
                    normal: 0.5 * slack * depth / dt,
                    slip: 0.5 * slack * self.settings.slip,
                    iterations: self.settings.iterations,
                };
                let one = case.solve(world, &mut self.solver);
                let one = one.map_err(|error| Cut::Fatal(error.into()))?;
                attempt.report.contact.iterations += one.iterations;
                attempt.report.contact.solves += 1;
                case.give_back(&mut attempt.touches);
                let impulses = world.impulses(&attempt.touches);
                let advanced = world.for_groups(|group, own| group.advance(own), &impulses);
                let turn = advanced.map_err(Cut::Rod)?.into_iter().fold(0.0, f64::max);
                case.velocities = world.at_points(&case.points, &world.velocities(false));
                let found = case.certificate(&vec![1e-8; case.contacts.len()]);
                let report = &mut attempt.report.contact;
                (report.residual, report.normal_error, report.slip_error) =
                    (found.residual, found.normal_error, found.slip_error);
                report.listed = case.contacts.len();
                report.active = case.impulses.iter().filter(|r| r.x != 0.0).count();
                if std::env::var("RZ_DEBUG").is_ok() {
                    eprintln!("t {time:.4} dt {dt:.1e} round {round} iteration {iteration} listed {} active {} it {} turn {turn:.1e} res {:.1e} n {:.1e} slip {:.1e}",
                        report.listed, report.active, one.iterations, found.residual, found.normal_error, found.slip_error);
                }
                solved = turn < SMALL_TURN
                    && found.residual <= self.settings.residual
                    && found.slip_error <= self.settings.slip
                    && found.normal_error * dt <= depth;
                if solved {
                    break;
                }
            }
            let mut before = std::mem::take(&mut attempt.touches);
            // What moved far since the contacts were listed may move as far again.
            let listed_at = std::mem::take(&mut attempt.mean);
            let mean = world.velocities(false);
            let moved = listed_at.iter().zip(&mean).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            let more = if round == 0 { (moved * dt).min(WIDEST * self.radius) } else { 0.0 };
            self.detect(world, attempt, &remember(&before), [time, dt], more)?;
            let gap = attempt.touches.iter().map(|t| t.gap).fold(f64::INFINITY, f64::min);
            attempt.report.contact.gap = gap;
            if std::env::var("RZ_DEBUG").is_ok() {
                eprintln!("     gap {gap:.2e} solved {solved}");
            }
            if solved && gap >= -depth {
                // What is remembered is what bore the step.
                attempt.touches = before;
                return Ok(());
            }
            if round > 0 && round < MOST_ROUNDS {
                for (touch, contact) in before.iter_mut().zip(&case.contacts) {
                    touch.gap = dt * contact.relative(&case.velocities).x;
                }
                attempt.touches = merged(before, &attempt.touches, 0.5 * depth);
                continue;
            }
            if round == MOST_ROUNDS {
                attempt.touches = before;
                return if last { Ok(()) } else { Err(Cut::Depth) };
            }
        }
        Ok(())
    }

    /// Finds the touches where the step has been solved to, with the impulses expected of them.
    fn detect(
        &mut self,
        world: &mut World,
        attempt: &mut Attempt,
        expected: &[Remembered],
        [time, dt]: [f64; 2],
        more: f64,
    ) -> Result<(), Cut> {
        attempt.mean = world.velocities(false);
        attempt.end =
            attempt.start.iter().zip(&attempt.mean).map(|(x, v)| x + v * dt).collect();
        let motion = Motion {
            layout: world.assembly().layout(),
            radii: &self.radii,
            start: &attempt.start,
            end: &attempt.end,
            time,
            dt,
        };
        let found = self.detector.touches(&motion, &self.objects, more, &mut attempt.touches);
        found.map_err(|error| Cut::Fatal(error.into()))?;
        recall(expected, &mut attempt.touches);
        Ok(())
    }
}

/// The touches of a list, with those of another in place of theirs, or beside them, that are deeper
/// than `depth`.
fn merged(mut list: Vec<Touch>, other: &[Touch], depth: f64) -> Vec<Touch> {
    let old = list.len();
    for deep in other.iter().filter(|touch| touch.gap < -depth) {
        let pair = (deep.fiber, deep.partner);
        let start = list[..old].partition_point(|t| (t.fiber, t.partner) < pair);
        let near = |t: &Touch| {
            let ([s, u], [v, w]) = (t.at(), deep.at());
            (s - v).abs().max((u - w).abs()) < 0.5
        };
        let same = list[start..old]
            .iter_mut()
            .take_while(|t| (t.fiber, t.partner) == pair)
            .find(|t| near(t));
        match same {
            Some(touch) => *touch = Touch { impulse: touch.impulse, ..*deep },
            None => list.push(Touch { impulse: Vector3::zeros(), ..*deep }),
        }
    }
    list.sort_by(Touch::order);
    list
}

/// The contacts of a step as the solver takes them.
struct Case {
    contacts: Vec<Contact>,
    /// Points of each group, and their velocities in the order of the groups.
    points: Vec<Vec<Point>>,
    velocities: Vec<Vector3<f64>>,
    /// The same with the next increments.
    linear: Vec<Vector3<f64>>,
    /// In the frames of the contacts.
    impulses: Vec<Vector3<f64>>,
}

impl Case {
    fn new(world: &World, friction: &LimitCurve, attempt: &Attempt, dt: f64) -> Self {
        let Attempt { touches, mean, .. } = attempt;
        let groups = world.groups.len();
        let mut points: Vec<Vec<Point>> = vec![Vec::new(); groups];
        let mut velocities: Vec<Vec<Vector3<f64>>> = vec![Vec::new(); groups];
        let layout = world.assembly().layout();
        let mut add = |fiber: u32, segment: u32, fraction: f64| {
            let (group, lane) = world.lane(fiber as usize);
            #[expect(clippy::cast_possible_truncation, reason = "there are eight lanes")]
            points[group].push(Point { fiber: lane as u32, segment, fraction });
            let node = layout.node_range(fiber as usize).start + segment as usize;
            velocities[group].push(mean[node].lerp(&mean[node + 1], fraction));
            (group, points[group].len() - 1)
        };
        let places: Vec<_> = touches
            .iter()
            .map(|touch| {
                let first = add(touch.fiber, touch.segments[0], touch.fractions[0]);
                let second = match touch.partner {
                    Partner::Fiber(f) => Some(add(f, touch.segments[1], touch.fractions[1])),
                    Partner::Object(_) => None,
                };
                (first, second)
            })
            .collect();
        let mut starts = vec![0];
        for group in &points {
            starts.push(starts[starts.len() - 1] + group.len());
        }
        let index = |(group, point): (usize, usize)| starts[group] + point;
        let velocities = velocities.concat();
        let mut impulses = Vec::with_capacity(touches.len());
        let contacts = touches
            .iter()
            .zip(&places)
            .map(|(touch, (first, second))| {
                let frame = frame(&touch.normal, &touch.axis);
                let (first, second) = (index(*first), second.map(index));
                impulses.push(frame.tr_mul(&touch.impulse));
                let mut contact = Contact {
                    first,
                    second,
                    frame,
                    bias: frame.tr_mul(&-touch.drive),
                    friction: friction.clone(),
                    adhesion: 0.0,
                    compliance: 0.0,
                };
                // At the velocities that led to this gap, the gap is what may still close.
                contact.bias.x = 0.0;
                contact.bias.x = touch.gap / dt - contact.relative(&velocities).x;
                contact
            })
            .collect();
        Self { contacts, points, linear: Vec::new(), velocities, impulses }
    }

    /// How well the law holds where the rods are, whose own responses are `weights`.
    fn certificate(&self, weights: &[f64]) -> Report {
        let velocities: Vec<_> =
            self.contacts.iter().map(|contact| contact.relative(&self.velocities)).collect();
        report(&self.contacts, &velocities, &self.impulses, weights)
    }

    fn solve(
        &mut self,
        world: &mut World,
        solver: &mut Admm,
    ) -> Result<Report, ContactError> {
        let mut bodies: Vec<Fibers> = world
            .groups
            .iter_mut()
            .zip(&self.points)
            .filter_map(|(group, points)| {
                Some(Fibers { batch: group.batch.coupled()?, points })
            })
            .collect();
        let mut bodies: Vec<&mut dyn Body> =
            bodies.iter_mut().map(|body| body as &mut dyn Body).collect();
        solver.solve(&mut bodies, &self.contacts, &self.linear, &mut self.impulses)
    }

    fn give_back(&self, touches: &mut [Touch]) {
        for ((touch, contact), impulse) in
            touches.iter_mut().zip(&self.contacts).zip(&self.impulses)
        {
            touch.impulse = contact.frame * impulse;
        }
    }
}

/// The frame of a contact: normal, along the fibre, across it.
fn frame(normal: &Vector3<f64>, axis: &Vector3<f64>) -> Matrix3<f64> {
    let along = axis - normal * normal.dot(axis);
    let other = || normal.cross(&Vector3::ith(normal.iamin(), 1.0));
    let along = along.try_normalize(1e-9 * axis.norm()).unwrap_or_else(|| other().normalize());
    Matrix3::from_columns(&[*normal, along, normal.cross(&along)])
}

impl World {
    /// Positions of all nodes, in the order of the assembly.
    fn positions(&self) -> Vec<Point3<f64>> {
        let layout = self.assembly().layout();
        let mut positions = Vec::with_capacity(layout.nodes());
        for fiber in 0..layout.fibers() {
            let (group, lane) = self.lane(fiber);
            let nodes = layout.node_range(fiber).len();
            positions.extend((0..nodes).map(|node| self.groups[group].batch.node(lane, node).0));
        }
        positions
    }

    /// Mean velocities of all nodes over the step as it has been solved so far, or with the
    /// increments of the last linearisation.
    fn velocities(&self, linear: bool) -> Vec<Vector3<f64>> {
        let layout = self.assembly().layout().clone();
        let mut all = vec![Vector3::zeros(); layout.nodes()];
        let mut own = Vec::new();
        for group in &self.groups {
            let Some(batch) = group.batch.as_coupled() else { continue };
            own.resize(rapunzel_rod_dynamic::ImpulseResponse::nodes(batch), Vector3::zeros());
            let read = if linear {
                batch.linear_velocities(&mut own)
            } else {
                batch.mean_velocities(&mut own)
            };
            debug_assert!(read.is_ok(), "there is a velocity for each node");
            let mut rest = &own[..];
            for &fiber in &group.fibers {
                let range = layout.node_range(fiber);
                let (head, tail) = rest.split_at(range.len());
                all[range].copy_from_slice(head);
                rest = tail;
            }
        }
        all
    }

    /// Values at points of the groups, interpolated from those of all nodes.
    fn at_points(&self, points: &[Vec<Point>], nodes: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let layout = self.assembly().layout();
        let mut values = Vec::new();
        for (group, points) in self.groups.iter().zip(points) {
            values.extend(points.iter().map(|point| {
                let fiber = group.fibers[point.fiber as usize];
                let node = layout.node_range(fiber).start + point.segment as usize;
                nodes[node].lerp(&nodes[node + 1], point.fraction)
            }));
        }
        values
    }

    /// Shares an impulse between the nodes of the segment that it acts on.
    fn add_impulse(&self, all: &mut [Vector3<f64>], fiber: u32, at: f64, impulse: &Vector3<f64>) {
        let range = self.assembly().layout().node_range(fiber as usize);
        #[expect(clippy::cast_possible_truncation, reason = "a place along a fibre")]
        let segment = (at as usize).min(range.len() - 2);
        let fraction = at - segment as f64;
        all[range.start + segment] += impulse * (1.0 - fraction);
        all[range.start + segment + 1] += impulse * fraction;
    }

    /// The impulses of all touches on all nodes.
    fn impulses(&self, touches: &[Touch]) -> Vec<Vector3<f64>> {
        let mut all = vec![Vector3::zeros(); self.assembly().layout().nodes()];
        for touch in touches.iter().filter(|touch| touch.impulse != Vector3::zeros()) {
            let [s, t] = touch.at();
            self.add_impulse(&mut all, touch.fiber, s, &touch.impulse);
            if let Partner::Fiber(partner) = touch.partner {
                self.add_impulse(&mut all, partner, t, &-touch.impulse);
            }
        }
        all
    }

    /// Lets every group do something with its part of the impulses, in parallel.
    fn for_groups<T: Send>(
        &mut self,
        act: impl Fn(&mut Group, &[Vector3<f64>]) -> Result<T, StepError> + Sync,
        impulses: &[Vector3<f64>],
    ) -> Result<Vec<T>, StepError> {
        let layout = self.assembly().layout().clone();
        let results: Vec<_> = self
            .groups
            .par_iter_mut()
            .map(|group| {
                let mut own = Vec::new();
                if !impulses.is_empty() {
                    for &fiber in &group.fibers {
                        own.extend_from_slice(&impulses[layout.node_range(fiber)]);
                    }
                }
                act(group, &own)
            })
            .collect();
        results.into_iter().collect()
    }

    fn accept(&mut self) {
        self.groups.iter_mut().filter_map(|g| g.batch.coupled()).for_each(|b| b.accept());
    }

    fn abandon(&mut self) {
        self.groups.iter_mut().filter_map(|g| g.batch.coupled()).for_each(|b| b.abandon());
    }
}
