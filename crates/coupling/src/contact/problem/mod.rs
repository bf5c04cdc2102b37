//! The contacts of a step as the solver takes them.

mod couples;
mod culling;
pub(super) mod groups;
mod near;
mod parameters;
mod residuals;
mod rolling;
mod sides;

use super::ball_joints::JointPoint;
use super::group_body::{DelassusCache, GroupBody};
use super::junctions::Couple;
use super::laws::ContactLaws;
use super::node_arrays::FiberVelocities;
use super::touched_parts::TouchedParts;
use super::velocities::Velocities;
use crate::contact::system::CoupledSystem;
use crate::contact_point::{ContactImpulse, ContactPoint};
use culling::{ALWAYS, ContactCulling};
use nalgebra::Vector3;
use parameters::ContactParameters;
use rapunzel_contact::{
    Body, Contact, ContactError, ContactSolver, ErrorMasses, FreeMasses, LimitCurve, Report,
    Solver, Tolerance,
};
use rapunzel_rod_dynamic::StepVelocity;
use rayon::prelude::*;
use sides::{ContactSide, each, traces};
use std::sync::{Mutex, PoisonError};

/// Residuals, and errors of velocities in m/s, below this take more than single precision.
const ROUNDING: f64 = 1e-5;

/// From so many contacts on, memory counts. To keep answers with added masses takes more of it than
/// it saves time: they are used again in one of seven solves, and take some 2 kB a contact.
const MANY_WORKING: usize = 50_000;

/// Answers of fibres that turn by less, rad, are used again.
const CHORD: f64 = 1e-2;

/// Where a contact is not among those that are solved.
const NONE: usize = usize::MAX;

/// All contacts of a list, in the order of the contact points they are made of.
pub(super) struct ContactProblem {
    /// Where the contacts are; with gaps and impulses when they were listed, until
    /// [`ContactProblem::give_impulses`] and [`ContactProblem::set_gaps`].
    points: Vec<ContactPoint>,
    /// How many of them are listed: all that follow are joints.
    listed: usize,
    /// What they touch, unless that is looked at whole.
    touched: Option<TouchedParts>,
    /// Those of the last joints, which are couples.
    couples: Vec<Couple>,
    laws: Vec<ContactParameters>,
    /// Impulses, N s, in the frames of the contacts.
    impulses: Vec<Vector3<f64>>,
    /// Impulses as those of the step before, N s, world; none where nothing gives way.
    before: Vec<Vector3<f64>>,
    /// Indices of contacts that bear something or that the solver looked at last, in their order.
    working: Vec<usize>,
    /// Impulses of these on their first sides, N s, world.
    pushes: Vec<Vector3<f64>>,
    /// Where there are so many that to look at all nodes costs less than to look at all contacts.
    openings: Option<ContactCulling>,
    /// By contact, the masses with which errors of impulses and of velocities are compared; of
    /// those that have not been solved that of a segment.
    masses: Vec<ErrorMasses>,
    /// What the last solve left, in tolerances.
    error: Option<f64>,
    /// By group: answers that are written out, as long as the fibres hardly turn.
    written: Vec<Option<DelassusCache>>,
    /// By group: the points that these have.
    kept: Vec<Vec<ContactSide>>,
    /// What the solver got last.
    solved: Vec<Contact>,
}

/// What a problem is made of.
pub(super) struct ContactLists {
    /// Contact points by pair and place.
    pub(super) points: Vec<ContactPoint>,
    pub(super) joints: Vec<JointPoint>,
    /// What bends at joints.
    pub(super) couples: Vec<(ContactPoint, Couple)>,
}

/// What takes most room in a case, for that of the next step.
#[derive(Default)]
pub(super) struct ProblemWorkspace {
    laws: Vec<ContactParameters>,
    solved: Vec<Contact>,
}

impl ContactProblem {
    /// The contacts of a step of `dt` seconds, whose contact points have their gaps where fibres
    /// have the mean velocities that are given back, of what they touch at least. What gives way
    /// has done so already under impulses as those of the step `before`, N s, world: along tangents
    /// only the rest of them moves it; along normals the gap tells. Joints close; what bends at
    /// them is in no balance yet ([`Self::bend`]). `mass`, kg, is that by which errors are judged
    /// at first.
    pub(super) fn new(
        system: &CoupledSystem,
        ContactLists { mut points, joints, couples }: ContactLists,
        dt: f64,
        laws: &ContactLaws,
        before: Vec<Vector3<f64>>,
        mass: f64,
        room: ProblemWorkspace,
    ) -> Result<(Self, FiberVelocities), ContactError> {
        let ProblemWorkspace { laws: mut own, solved } = room;
        let turning = system.fibers.turning_parts();
        points.par_iter_mut().for_each(|point| point.act_on_axis_outside(&turning));
        let refused = Mutex::new(None::<(usize, ContactError)>);
        let bound =
            joints.iter().map(|joint| &joint.point).chain(couples.iter().map(|(point, _)| point));
        let touched = TouchedParts::new(system.fibers, points.iter().chain(bound));
        let of = |which| system.fibers.velocities(which, touched.as_ref());
        let start = laws.look_back().then(|| of(StepVelocity::Start));
        let first = start.as_ref().map(|start| Velocities::before(system, start));
        let velocities = of(StepVelocity::Mean);
        let mean = Velocities::new(system, &velocities);
        let nodes = mean.nodes();
        let law = |(i, point): (usize, &ContactPoint)| {
            let frame = point.frame();
            let relative = |velocities: &Velocities| frame.tr_mul(&velocities.between(point));
            let drive = frame.tr_mul(&point.drive());
            // At the velocities that led to this gap, the gap is what may still close.
            let gap = point.gap / dt - relative(&mean).x;
            // Where no law looks back nothing asks for it.
            let first = || first.as_ref().map_or_else(Vector3::zeros, relative) - drive;
            let friction = laws.friction(point, first).unwrap_or_else(|error| {
                let mut refused = refused.lock().unwrap_or_else(PoisonError::into_inner);
                if refused.as_ref().is_none_or(|(first, _)| i < *first) {
                    *refused = Some((i, error));
                }
                LimitCurve::Circle { mu: 0.0 }
            });
            let closing = laws.closing(point, gap, first);
            let compliance = if closing < gap { 0.0 } else { laws.compliance() };
            // What has slipped from where it stuck is to go back there.
            let back = frame.tr_mul(&point.undone(dt, laws.slip()));
            let mut bias = Vector3::new(closing, back.y - drive.y, back.z - drive.z);
            if compliance > 0.0 {
                let given = frame.tr_mul(&before[i]) * compliance;
                bias -= Vector3::new(0.0, given.y, given.z);
            }
            let impulse = match point.impulse {
                none if none == Vector3::zeros() => none,
                world => frame.tr_mul(&world),
            };
            (ContactParameters { bias, friction, adhesion: 0.0, compliance, gap }, impulse)
        };
        let made = points.par_iter().enumerate().map(law);
        // Twice the room, as they would grow by, is much.
        own.clear();
        own.reserve_exact(points.len());
        let mut impulses = Vec::new();
        made.unzip_into_vecs(&mut own, &mut impulses);
        drop(start);
        if let Some((_, error)) = refused.into_inner().unwrap_or_else(PoisonError::into_inner) {
            return Err(error);
        }
        let pulls =
            laws.adhesion(system.fibers.assembly(), &points, own.iter().map(|law| law.gap))?;
        own.iter_mut().zip(pulls).for_each(|(law, pull)| law.adhesion = pull);
        let listed = points.len();
        for JointPoint { point, gap } in joints {
            let frame = point.frame();
            own.push(ContactParameters::joint(&point, gap / dt - mean.between(&point)));
            impulses.push(frame.tr_mul(&point.impulse));
            points.push(point);
        }
        let mut levers = Vec::with_capacity(couples.len());
        for (point, couple) in couples {
            own.push(ContactParameters::couple(couple.compliance));
            impulses.push(point.frame().tr_mul(&point.impulse));
            points.push(point);
            levers.push(couple);
        }
        let acts = |point: &ContactPoint| point.working || point.impulse != Vector3::zeros();
        let openings = (points.len() > nodes.len()).then(|| {
            let speeds = points.par_iter().zip(&own).map(|(point, law)| {
                let always = acts(point) || law.adhesion > 0.0 || law.is_joint();
                if always { ALWAYS } else { point.gap / dt + law.bias.x - law.gap }
            });
            ContactCulling::new(system, &points, speeds.collect(), nodes)
        });
        let working: Vec<usize> = (0..points.len())
            .into_par_iter()
            .filter(|&i| i >= listed || acts(&points[i]))
            .collect();
        let pushes = working.iter().map(|&i| points[i].impulse).collect();
        let masses = vec![ErrorMasses::from(mass); points.len()];
        let written = system.fibers.groups.iter().map(|_| None).collect();
        let (error, kept) = (None, vec![Vec::new(); system.fibers.groups.len()]);
        let problem = Self {
            points,
            listed,
            touched,
            couples: levers,
            laws: own,
            impulses,
            before,
            working,
            pushes,
            openings,
            masses,
            error,
            written,
            kept,
            solved,
        };
        Ok((problem, velocities))
    }

    /// Takes the problem apart: its contact points, and its workspace for the next.
    pub(super) fn into_parts(mut self) -> (Vec<ContactPoint>, ProblemWorkspace) {
        self.points.truncate(self.listed);
        (self.points, ProblemWorkspace { laws: self.laws, solved: self.solved })
    }

    /// Velocities of the step under way of what the contact points touch.
    pub(super) fn velocities(
        &self,
        system: &CoupledSystem,
        which: StepVelocity,
    ) -> FiberVelocities {
        system.fibers.velocities(which, self.touched.as_ref())
    }

    /// The contact points, without joints.
    pub(super) fn points(&self) -> &[ContactPoint] {
        &self.points[..self.listed]
    }

    /// What the last iteration left, in tolerances; `None` before the first.
    pub(super) fn error(&self) -> Option<f64> {
        self.error
    }

    pub(super) fn set_error(&mut self, error: f64) {
        self.error = Some(error);
    }

    /// Points that are used no more stay where answers are written out that have all that are used,
    /// by group.
    fn keep(&mut self, used: &mut [Vec<ContactSide>]) {
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

    /// Solves for the impulses, with the rods as they are linearised, or, as far as their answers
    /// go, as they were when these were written out. Only contacts that bear something, pull or
    /// would close, or did so before, are looked at: all others would do nothing but hold back the
    /// solver. Those that this lets close take part the next time.
    pub(super) fn solve(
        &mut self,
        system: &mut CoupledSystem,
        solver: &mut ContactSolver,
        patient: bool,
    ) -> Result<Report, ContactError> {
        let fibers = self.velocities(system, StepVelocity::Linear);
        let linear = Velocities::new(system, &fibers);
        let near = self.look(system, &linear);
        let works = near
            .par_iter()
            .map(|&i| patient && self.working.binary_search(&i).is_ok() || self.acts(i, &linear));
        let works: Vec<bool> = works.collect();
        let working = near.into_iter().zip(works).filter_map(|(i, works)| works.then_some(i));
        let working: Vec<usize> = working.collect();
        if let Some(openings) = &mut self.openings {
            openings.hold(&working);
        }
        let [mut used, on_objects] = self.sides(system, &working);
        self.keep(&mut used);
        let sides: Vec<ContactSide> = used.iter().chain(&on_objects).flatten().copied().collect();
        let mut place = vec![NONE; self.laws.len()];
        working.iter().enumerate().for_each(|(k, &i)| place[i] = k);
        let mut index = vec![[0; 2]; working.len()];
        for (point, &(i, side)) in sides.iter().enumerate() {
            // What is only kept has no contact.
            if place[i] != NONE {
                index[place[i]][side] = point;
            }
        }
        let of_side = |&(i, side): &ContactSide| self.of_side(i, side, &linear);
        let velocities: Vec<_> = sides.par_iter().map(of_side).collect();
        drop(fibers);
        let (laws, all) = (&self.laws, working.par_iter().zip(&index));
        let solved = all.map(|(&i, sides)| laws[i].contact(&self.points[i], *sides));
        self.solved.clear();
        self.solved.reserve_exact(working.len());
        solved.collect_into_vec(&mut self.solved);
        let mut impulses: Vec<_> = working.iter().map(|&i| self.impulses[i]).collect();
        let points = each(&used, |i, side| self.rod_point(system, i, side));
        let levers = each(&on_objects, |i, side| self.points[i].lever(side));
        let mut free = system.free_bodies(&levers)?;
        let &Tolerance { residual, normal, slip, .. } = solver.tolerance();
        let exact = residual.min(normal).min(slip) < ROUNDING;
        let few = working.len() < MANY_WORKING;
        let groups = system.fibers.groups.par_iter_mut().zip(&points).zip(&mut self.written);
        let mut fibers: Vec<GroupBody> = groups
            .map(|((group, points), written)| {
                GroupBody::new(&mut group.batch, points, exact, few, written)
            })
            .collect::<Result<_, ContactError>>()?;
        let mut bodies: Vec<&mut dyn Body> =
            fibers.iter_mut().map(|fibers| fibers as &mut dyn Body).collect();
        bodies.extend(free.iter_mut().map(|body| body as &mut dyn Body));
        let (traces, free) = (traces(&mut bodies), FreeMasses::new(&bodies, &self.solved));
        let report = solver.solve(&mut bodies, &self.solved, &velocities, &mut impulses)?;
        let pushes =
            self.solved.par_iter().zip(&impulses).map(|(contact, own)| contact.frame * own);
        pushes.collect_into_vec(&mut self.pushes);
        working.iter().zip(impulses).for_each(|(&i, impulse)| self.impulses[i] = impulse);
        self.weigh(&working, &traces, &free);
        self.working = working;
        Ok(report)
    }

    /// Notes the masses that solved contacts compare errors with, by the traces of how their points
    /// answer themselves. A free body may be far heavier than the fibre that presses it: where they
    /// touch it stays that of a segment. Where nothing but free bodies moves, errors of impulses
    /// are those of the heaviest.
    fn weigh(&mut self, working: &[usize], traces: &[f64], free: &FreeMasses) {
        let both = working.par_iter().zip(&self.solved);
        let of_one = both.map(|(&i, contact)| {
            let second = contact.second.map_or(0.0, |point| traces[point]);
            let (trace, moved) = (traces[contact.first] + second, free.of(contact));
            let judged = trace > 0.0 && (moved > 0.0 || !self.points[i].has_free());
            judged.then(|| ErrorMasses { own: 3.0 / trace, moved: moved.max(3.0 / trace) })
        });
        let masses: Vec<Option<ErrorMasses>> = of_one.collect();
        for (&i, masses) in working.iter().zip(masses) {
            self.masses[i] = masses.unwrap_or(self.masses[i]);
        }
    }

    /// Impulses of the contacts that bear something or that the solver looked at last.
    pub(super) fn pushes(&self) -> impl Iterator<Item = ContactImpulse> + Clone {
        self.working.iter().zip(&self.pushes).map(|(&i, push)| match self.couple(i) {
            None => self.points[i].push(*push),
            Some(Couple { lever, .. }) => {
                ContactImpulse { couple: true, ..self.points[i].push(lever * push) }
            }
        })
    }

    /// Writes the impulses into the contact points, and which of them the solver looked at last.
    /// Returns those of joints, N s, and the moments of those of couples, N m s, world.
    pub(super) fn give_impulses(&mut self) -> Vec<Vector3<f64>> {
        self.points.par_iter_mut().for_each(|point| {
            (point.impulse, point.working) = (Vector3::zeros(), false);
        });
        for (&i, push) in self.working.iter().zip(&self.pushes) {
            (self.points[i].impulse, self.points[i].working) = (*push, true);
        }
        let joints = self.points.iter().enumerate().skip(self.listed);
        let of_one = |(i, joint): (usize, &ContactPoint)| match self.couple(i) {
            None => joint.impulse,
            Some(Couple { lever, .. }) => lever * joint.impulse,
        };
        joints.map(of_one).collect()
    }

    /// Whether a contact bears something, pulls, or closes where things are so fast.
    fn acts(&self, i: usize, velocities: &Velocities) -> bool {
        let law = &self.laws[i];
        self.impulses[i] != Vector3::zeros()
            || law.adhesion > 0.0
            || law.is_joint()
            || law.opening(&self.points[i], velocities) < 0.0
    }
}
