//! The contacts of a step as the solver takes them.

use super::body::{Fibers, Written};
use super::law::Laws;
use super::touch::{Partner, Touch};
use super::velocities::Velocities;
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

/// A side of a contact: that one's number, and 0 or 1.
type Side = (usize, usize);

/// All contacts of a list, in the order of the touches they are made of. As long as it stands these keep
/// their order; what is asked of it takes them.
pub(super) struct Case {
    /// Each as if its sides were points of their own, two a contact.
    contacts: Vec<Contact>,
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
    /// By group: the points that these have.
    kept: Vec<Vec<Side>>,
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
        let is_led = |side: Partner| match side {
            Partner::Object(object) => !world.objects[object as usize].is_free(),
            Partner::Fiber(_) => false,
        };
        let (before, mean) = (Velocities::before(world, before), Velocities::new(world, mean));
        let contact = |(i, touch): (usize, &Touch)| {
            let frame = frame(&touch.normal, &touch.axis);
            let relative = |velocities: &Velocities| frame.tr_mul(&velocities.between(touch));
            let drive = frame.tr_mul(&touch.drive);
            // At the velocities that led to this gap, the gap is what may still close.
            let gap = touch.gap / dt - relative(&mean).x;
            let before = relative(&before) - drive;
            let friction = laws.friction(touch, &before);
            let contact = friction.map(|friction| Contact {
                first: 2 * i,
                second: (!is_led(touch.sides[1])).then_some(2 * i + 1),
                frame,
                bias: Vector3::new(laws.closing(touch, gap, before.x), -drive.y, -drive.z),
                friction,
                adhesion: 0.0,
                compliance: 0.0,
            });
            (contact, gap)
        };
        let (mut contacts, mut gaps) = (Vec::new(), Vec::new());
        let made = touches.par_iter().enumerate().map(contact);
        made.unzip_into_vecs(&mut contacts, &mut gaps);
        let mut contacts = contacts.into_iter().collect::<Result<Vec<_>, ContactError>>()?;
        let pulls = laws.adhesion(world.assembly(), touches, &gaps)?;
        contacts.iter_mut().zip(pulls).for_each(|(contact, pull)| contact.adhesion = pull);
        let impulses =
            touches.par_iter().zip(&contacts).map(|(t, c)| c.frame.tr_mul(&t.impulse)).collect();
        let masses = world.assembly().fibers().iter().map(|f| f.mass() / f.segments() as f64);
        let working = touches.iter().map(|touch| touch.working).collect();
        let mass = masses.fold(f64::INFINITY, f64::min);
        let written = world.groups.iter().map(|_| None).collect();
        let (error, kept) = (None, vec![Vec::new(); world.groups.len()]);
        Ok(Self { contacts, impulses, gaps, working, mass, error, written, kept })
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

    /// Points that are used no more stay where answers are written out that have all that are used, by group.
    fn keep(&mut self, used: &mut [Vec<Side>]) {
        for ((used, kept), written) in used.iter_mut().zip(&mut self.kept).zip(&mut self.written) {
            let known = || used.iter().all(|side| kept.binary_search(side).is_ok());
            if written.is_some() && known() {
                used.clone_from(kept);
            } else {
                *written = None;
                kept.clone_from(used);
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
        touches: &[Touch],
        solver: &mut Admm,
        patient: bool,
    ) -> Result<Report, ContactError> {
        let nodes = world.linear_velocities();
        let linear = Velocities::new(world, &nodes);
        self.working.par_iter_mut().enumerate().for_each(|(i, working)| {
            *working = patient && *working
                || self.impulses[i] != Vector3::zeros()
                || self.contacts[i].adhesion > 0.0
                || relative(&self.contacts[i], &touches[i], &linear).x < 0.0;
        });
        let working: Vec<usize> = (0..self.working.len()).filter(|&i| self.working[i]).collect();
        let mut used = vec![Vec::new(); world.groups.len()];
        let mut on_objects = vec![Vec::new(); world.objects.len()];
        for &i in &working {
            let Contact { first, second, .. } = &self.contacts[i];
            for point in [Some(*first), *second].into_iter().flatten() {
                let side = (i, point % 2);
                match touches[i].sides[side.1] {
                    Partner::Fiber(fiber) => used[world.lane(fiber as usize).0].push(side),
                    Partner::Object(object) => on_objects[object as usize].push(side),
                }
            }
        }
        self.keep(&mut used);
        let sides = || used.iter().chain(&on_objects).flatten();
        let mut index = vec![[0; 2]; touches.len()];
        sides().enumerate().for_each(|(point, &(i, side))| index[i][side] = point);
        let velocities: Vec<_> =
            sides().map(|&(i, side)| linear.of_side(&touches[i], side)).collect();
        let contacts: Vec<_> = working
            .par_iter()
            .map(|&i| {
                let contact = self.contacts[i].clone();
                let second = contact.second.map(|_| index[i][1]);
                Contact { first: index[i][0], second, ..contact }
            })
            .collect();
        let mut impulses: Vec<_> = working.iter().map(|&i| self.impulses[i]).collect();
        let points = each(&used, |i, side| point(world, &touches[i], side));
        let levers = each(&on_objects, |i, side| touches[i].levers[side]);
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
    pub(super) fn certificate(
        &self,
        world: &World,
        touches: &[Touch],
        mean: &[Vector3<f64>],
    ) -> Report {
        let mean = Velocities::new(world, mean);
        let both = self.contacts.par_iter().zip(touches);
        let velocities: Vec<_> = both.map(|(c, touch)| relative(c, touch, &mean)).collect();
        report(&self.contacts, &velocities, &self.impulses, &vec![self.mass; self.contacts.len()])
    }

    /// Which contact is farthest from the law where all nodes have the given mean velocities.
    pub(super) fn worst(
        &self,
        world: &World,
        touches: &[Touch],
        mean: &[Vector3<f64>],
    ) -> Option<usize> {
        let mean = Velocities::new(world, mean);
        let wrong = |i: usize| {
            let velocity = relative(&self.contacts[i], &touches[i], &mean);
            Violation::new(&self.contacts[i], &velocity, &self.impulses[i], self.mass).impulse
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
        touches: &[Touch],
        mean: &[Vector3<f64>],
    ) -> ContactWork {
        let mean = Velocities::new(world, mean);
        let mut work = ContactWork::default();
        let bearing = |i: &usize| self.impulses[*i] != Vector3::zeros();
        for i in (0..touches.len()).filter(bearing) {
            let (contact, touch, impulse) = (&self.contacts[i], &touches[i], &self.impulses[i]);
            let velocity = relative(contact, touch, &mean);
            let drive = contact.frame.tr_mul(&touch.drive);
            // The bias along the normal is not that of the drive alone.
            let opening = velocity.x - contact.bias.x - drive.x;
            work += ContactWork {
                friction: impulse.yz().dot(&velocity.yz()),
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
        touches: &mut [Touch],
        mean: &[Vector3<f64>],
        [strength, tolerance]: [f64; 2],
    ) -> Result<(), ContactError> {
        let mean = Velocities::new(world, mean);
        for (i, touch) in touches.iter_mut().enumerate().filter(|(_, touch)| touch.bonded) {
            let mut bond = Bond::new(strength)?;
            let velocity = relative(&self.contacts[i], touch, &mean);
            bond.update(&self.contacts[i], &velocity, &self.impulses[i], tolerance);
            touch.bonded = bond.is_intact();
        }
        Ok(())
    }

    /// The gaps along the normals, m, where all nodes have the given mean velocities.
    pub(super) fn gaps(
        &self,
        world: &World,
        touches: &[Touch],
        mean: &[Vector3<f64>],
        dt: f64,
    ) -> Vec<f64> {
        let mean = Velocities::new(world, mean);
        // The bias may be another than that of the gap.
        let gap = |i: usize| {
            let contact = &self.contacts[i];
            dt * (relative(contact, &touches[i], &mean).x - contact.bias.x + self.gaps[i])
        };
        (0..self.contacts.len()).into_par_iter().map(gap).collect()
    }
}

/// The relative velocity of a contact, in its frame and with its bias, m/s.
fn relative(contact: &Contact, touch: &Touch, velocities: &Velocities) -> Vector3<f64> {
    contact.frame.tr_mul(&velocities.between(touch)) + contact.bias
}

/// A side of a touch that is a fibre, as a point of its group.
fn point(world: &World, touch: &Touch, side: usize) -> Point {
    let fiber = match touch.sides[side] {
        Partner::Fiber(fiber) => world.lane(fiber as usize).1,
        Partner::Object(_) => 0,
    };
    #[expect(clippy::cast_possible_truncation, reason = "there are eight lanes")]
    Point { fiber: fiber as u32, segment: touch.segments[side], fraction: touch.fractions[side] }
}

/// Something of every side, in lists as they are given.
fn each<T>(sides: &[Vec<Side>], of_side: impl Fn(usize, usize) -> T) -> Vec<Vec<T>> {
    let list = |sides: &Vec<Side>| sides.iter().map(|&(i, side)| of_side(i, side)).collect();
    sides.iter().map(list).collect()
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
