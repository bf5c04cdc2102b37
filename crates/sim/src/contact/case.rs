//! The contacts of a step as the solver takes them.

use super::body::{Fibers, Written};
use super::law::Laws;
use super::touch::{Partner, Touch};
use super::work::ContactWork;
use crate::World;
use nalgebra::{Matrix3, Vector3};
use rapunzel_contact::{
    Admm, Body, Bond, Contact, ContactError, Report, Solver, Tolerance, Violation, report,
};
use rapunzel_rod_dynamic::Point;
use rayon::prelude::*;

/// Residuals, and errors of velocities in m/s, below this take more than single precision.
const ROUNDING: f64 = 1e-5;

/// Answers of fibres that turn by less, rad, are used again.
const CHORD: f64 = 1e-2;

/// All contacts between the points of all groups, in the order of the touches they are made of.
pub(super) struct Case {
    contacts: Vec<Contact>,
    /// By group.
    points: Vec<Vec<Point>>,
    /// By object; none on those that are led.
    levers: Vec<Vec<Vector3<f64>>>,
    /// Impulses, N s, in the frames of the contacts.
    impulses: Vec<Vector3<f64>>,
    /// The gaps at the start of the step over its length, m/s.
    gaps: Vec<f64>,
    /// Those that the solver looks at.
    working: Vec<bool>,
    /// The mass (kg) with which errors of impulses and of velocities are compared.
    mass: f64,
    /// What the last solve left, in tolerances.
    error: Option<f64>,
    /// By group: answers that are written out, as long as the fibres hardly turn.
    written: Vec<Option<Written>>,
    /// The points that these have.
    kept: Vec<bool>,
}

impl Case {
    /// The contacts of a step of `dt` seconds, by the velocities of all nodes before it and, as
    /// means over it, those where the touches have their gaps.
    pub(super) fn new(
        world: &World,
        touches: &[Touch],
        [before, mean]: [&[Vector3<f64>]; 2],
        dt: f64,
        laws: &Laws,
    ) -> Result<Self, ContactError> {
        let mut points: Vec<Vec<Point>> = vec![Vec::new(); world.groups.len()];
        let mut add = |fiber: u32, segment: u32, fraction: f64| {
            let (group, lane) = world.lane(fiber as usize);
            #[expect(clippy::cast_possible_truncation, reason = "there are eight lanes")]
            points[group].push(Point { fiber: lane as u32, segment, fraction });
            (group, points[group].len() - 1)
        };
        let mut levers = vec![Vec::new(); world.objects.len()];
        let mut place = |touch: &Touch, side: usize| match touch.sides[side] {
            Partner::Fiber(fiber) => add(fiber, touch.segments[side], touch.fractions[side]),
            Partner::Object(object) => {
                let levers = &mut levers[object as usize];
                levers.push(touch.levers[side]);
                (world.groups.len() + object as usize, levers.len() - 1)
            }
        };
        let is_led = |side: Partner| match side {
            Partner::Object(object) => !world.objects[object as usize].is_free(),
            Partner::Fiber(_) => false,
        };
        let places: Vec<_> = touches
            .iter()
            .map(|touch| {
                let first = place(touch, 0);
                (first, (!is_led(touch.sides[1])).then(|| place(touch, 1)))
            })
            .collect();
        let mut starts = vec![0];
        for body in points.iter().map(Vec::len).chain(levers.iter().map(Vec::len)) {
            starts.push(starts[starts.len() - 1] + body);
        }
        let index = |(group, point): (usize, usize)| starts[group] + point;
        let mut velocities = world.at_points(&points, mean);
        velocities.extend(world.at_levers(&levers));
        let mut before = world.at_points(&points, before);
        before.extend(world.at_levers_before(&levers));
        type Place = ((usize, usize), Option<(usize, usize)>);
        let contact = |(touch, (first, second)): (&Touch, &Place)| {
            let frame = frame(&touch.normal, &touch.axis);
            let (first, second) = (index(*first), second.map(index));
            let relative = |velocities: &[Vector3<f64>]| {
                let other = second.map_or_else(Vector3::zeros, |second| velocities[second]);
                frame.tr_mul(&(velocities[first] - other))
            };
            let drive = frame.tr_mul(&touch.drive);
            // At the velocities that led to this gap, the gap is what may still close.
            let gap = touch.gap / dt - relative(&velocities).x;
            let before = relative(&before) - drive;
            let friction = laws.friction(touch, &before);
            let contact = friction.map(|friction| Contact {
                first,
                second,
                frame,
                bias: Vector3::new(laws.closing(touch, gap, before.x), -drive.y, -drive.z),
                friction,
                adhesion: 0.0,
                compliance: 0.0,
            });
            (contact, gap)
        };
        let (mut contacts, mut gaps) = (Vec::new(), Vec::new());
        let made = touches.par_iter().zip(&places).map(contact);
        made.unzip_into_vecs(&mut contacts, &mut gaps);
        let mut contacts = contacts.into_iter().collect::<Result<Vec<_>, ContactError>>()?;
        let pulls = laws.adhesion(world.assembly(), touches, &gaps)?;
        contacts.iter_mut().zip(pulls).for_each(|(contact, pull)| contact.adhesion = pull);
        let impulses =
            touches.par_iter().zip(&contacts).map(|(t, c)| c.frame.tr_mul(&t.impulse)).collect();
        let masses = world.assembly().fibers().iter().map(|f| f.mass() / f.segments() as f64);
        let working = touches.iter().map(|touch| touch.working).collect();
        let mass = masses.fold(f64::INFINITY, f64::min);
        let written = points.iter().map(|_| None).collect();
        let (error, kept) = (None, Vec::new());
        Ok(Self { contacts, points, levers, impulses, gaps, working, mass, error, written, kept })
    }

    pub(super) fn contacts(&self) -> usize {
        self.contacts.len()
    }

    /// What the last iteration left, in tolerances; `None` before the first.
    pub(super) fn error(&self) -> Option<f64> {
        self.error
    }

    pub(super) fn set_error(&mut self, error: f64) {
        self.error = Some(error);
    }

    /// Points that are used no more stay where answers are written out that have all that are used.
    fn keep(&mut self, used: &mut [bool]) {
        self.kept.resize(used.len(), false);
        let mut start = 0;
        for (points, written) in self.points.iter().zip(&mut self.written) {
            let range = start..start + points.len();
            start = range.end;
            let (used, kept) = (&mut used[range.clone()], &mut self.kept[range]);
            let known = used.iter().zip(&*kept).all(|(used, kept)| *kept || !used);
            if written.is_some() && known {
                used.copy_from_slice(kept);
            } else {
                *written = None;
                kept.copy_from_slice(used);
            }
        }
    }

    /// Tells by how much the fibres of every group have turned, rad.
    pub(super) fn turned(&mut self, turns: &[f64]) {
        for (written, turn) in self.written.iter_mut().zip(turns) {
            if *turn > CHORD {
                *written = None;
            }
        }
    }

    /// Number of contacts that bear something.
    pub(super) fn active(&self) -> usize {
        self.impulses.iter().filter(|impulse| **impulse != Vector3::zeros()).count()
    }

    /// Solves for the impulses, with the rods as they are linearised, or, as far as their answers go, as
    /// they were when these were written out. Only contacts that bear something, pull or would close, or
    /// did so before, are looked at: all others would do nothing but hold back the solver. Those that this
    /// lets close take part the next time.
    pub(super) fn solve(
        &mut self,
        world: &mut World,
        solver: &mut Admm,
        patient: bool,
    ) -> Result<Report, ContactError> {
        let velocities = self.at_points(world, &world.linear_velocities());
        self.working.par_iter_mut().enumerate().for_each(|(i, working)| {
            *working = patient && *working
                || self.impulses[i] != Vector3::zeros()
                || self.contacts[i].adhesion > 0.0
                || self.contacts[i].relative(&velocities).x < 0.0;
        });
        let working: Vec<usize> = (0..self.working.len()).filter(|&i| self.working[i]).collect();
        let mut used = vec![false; velocities.len()];
        for &i in &working {
            used[self.contacts[i].first] = true;
            self.contacts[i].second.into_iter().for_each(|second| used[second] = true);
        }
        self.keep(&mut used);
        let kept = |point: &usize| used[*point];
        let mut index = vec![0; used.len()];
        (0..used.len()).filter(kept).enumerate().for_each(|(new, old)| index[old] = new);
        let velocities: Vec<_> = (0..used.len()).filter(kept).map(|i| velocities[i]).collect();
        let contacts: Vec<_> = working
            .par_iter()
            .map(|&i| {
                let contact = self.contacts[i].clone();
                let second = contact.second.map(|second| index[second]);
                Contact { first: index[contact.first], second, ..contact }
            })
            .collect();
        let mut impulses: Vec<_> = working.iter().map(|&i| self.impulses[i]).collect();
        let mut used = used.into_iter();
        let points = select(&self.points, &mut used);
        let levers = select(&self.levers, &mut used);
        let mut free = world.free_bodies(&levers)?;
        let Tolerance { residual, normal, slip, .. } = solver.tolerance;
        let exact = residual.min(normal).min(slip) < ROUNDING;
        let groups = world.groups.par_iter_mut().zip(&points).zip(&mut self.written);
        let mut fibers: Vec<Fibers> = groups
            .filter_map(|((group, points), written)| {
                Some(Fibers::new(group.batch.coupled()?, points, exact, written))
            })
            .collect::<Result<_, ContactError>>()?;
        let mut bodies: Vec<&mut dyn Body> =
            fibers.iter_mut().map(|fibers| fibers as &mut dyn Body).collect();
        bodies.extend(free.iter_mut().map(|body| body as &mut dyn Body));
        let report = solver.solve(&mut bodies, &contacts, &velocities, &mut impulses)?;
        for (i, impulse) in working.into_iter().zip(impulses) {
            self.impulses[i] = impulse;
        }
        Ok(report)
    }

    /// How well the law holds where all nodes have the given mean velocities.
    pub(super) fn certificate(&self, world: &World, mean: &[Vector3<f64>]) -> Report {
        let velocities = self.relative(world, mean);
        report(&self.contacts, &velocities, &self.impulses, &vec![self.mass; self.contacts.len()])
    }

    /// Which contact is farthest from the law where all nodes have the given mean velocities.
    pub(super) fn worst(&self, world: &World, mean: &[Vector3<f64>]) -> Option<usize> {
        let velocities = self.relative(world, mean);
        let wrong = |i: usize| {
            Violation::new(&self.contacts[i], &velocities[i], &self.impulses[i], self.mass).impulse
        };
        (0..self.contacts.len()).max_by(|&i, &j| wrong(i).total_cmp(&wrong(j)))
    }

    /// Gives the impulses back to the touches, and tells which the solver looks at.
    pub(super) fn give_impulses(&self, touches: &mut [Touch]) {
        touches.par_iter_mut().enumerate().for_each(|(i, touch)| {
            touch.impulse = self.contacts[i].frame * self.impulses[i];
            touch.working = self.working[i];
        });
    }

    /// What the contacts do where all nodes have the given mean velocities.
    pub(super) fn work(
        &self,
        world: &World,
        mean: &[Vector3<f64>],
        touches: &[Touch],
    ) -> ContactWork {
        let velocities = self.relative(world, mean);
        let mut work = ContactWork::default();
        for (i, touch) in touches.iter().enumerate() {
            let (contact, impulse) = (&self.contacts[i], &self.impulses[i]);
            let drive = contact.frame.tr_mul(&touch.drive);
            // The bias along the normal is not that of the drive alone.
            let opening = velocities[i].x - contact.bias.x - drive.x;
            work += ContactWork {
                friction: impulse.yz().dot(&velocities[i].yz()),
                normal: impulse.x * opening,
                led: impulse.dot(&drive),
            };
        }
        work
    }

    /// Breaks the bonds of `strength`, N, that open against all that they bear, faster than
    /// `tolerance`, m/s, where all nodes have the given mean velocities.
    pub(super) fn tear(
        &self,
        world: &World,
        mean: &[Vector3<f64>],
        [strength, tolerance]: [f64; 2],
        touches: &mut [Touch],
    ) -> Result<(), ContactError> {
        let velocities = self.relative(world, mean);
        for (i, touch) in touches.iter_mut().enumerate().filter(|(_, touch)| touch.bonded) {
            let mut bond = Bond::new(strength)?;
            bond.update(&self.contacts[i], &velocities[i], &self.impulses[i], tolerance);
            touch.bonded = bond.is_intact();
        }
        Ok(())
    }

    /// The gaps along the normals, m, where all nodes have the given mean velocities.
    pub(super) fn gaps(&self, world: &World, mean: &[Vector3<f64>], dt: f64) -> Vec<f64> {
        let velocities = self.relative(world, mean);
        // The bias may be another than that of the gap.
        let gap = |i: usize| dt * (velocities[i].x - self.contacts[i].bias.x + self.gaps[i]);
        (0..self.contacts.len()).map(gap).collect()
    }

    /// Velocities of all points where all nodes have the given ones.
    fn at_points(&self, world: &World, nodes: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut velocities = world.at_points(&self.points, nodes);
        velocities.extend(world.at_levers(&self.levers));
        velocities
    }

    fn relative(&self, world: &World, mean: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let velocities = self.at_points(world, mean);
        self.contacts.par_iter().map(|contact| contact.relative(&velocities)).collect()
    }
}

/// Of the things of each body those that are used, as `used` tells one after another.
fn select<T: Copy>(all: &[Vec<T>], used: &mut impl Iterator<Item = bool>) -> Vec<Vec<T>> {
    let of_body = |things: &Vec<T>| {
        things
            .iter()
            .zip(used.by_ref())
            .filter_map(|(thing, used)| used.then_some(*thing))
            .collect()
    };
    all.iter().map(of_body).collect()
}

/// By this, rad, a normal along a fibre is tilted.
const TILT: f64 = 1e-9;

/// The frame of a contact: normal, along the fibre from root to tip, across it; without an axis any
/// two directions across the normal.
fn frame(normal: &Vector3<f64>, axis: &Vector3<f64>) -> Matrix3<f64> {
    let along = axis - normal * normal.dot(axis);
    let end_on = || {
        let aside = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
        // A straight fibre pressed exactly end-on buckles to a side only if it is pushed to one.
        let tilt = if *axis == Vector3::zeros() { 0.0 } else { TILT };
        ((normal + tilt * aside).normalize(), aside)
    };
    let oblique = along.try_normalize(1e-6 * axis.norm()).map(|along| (*normal, along));
    let (normal, along) = oblique.unwrap_or_else(end_on);
    // Once more, for what rounding left along the normal.
    let along = (along - normal * normal.dot(&along)).normalize();
    Matrix3::from_columns(&[normal, along, normal.cross(&along)])
}
