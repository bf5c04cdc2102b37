use super::contact_work::ContactWork;
use super::node_arrays::{FiberVelocities, StepEnds};
use super::node_motion::NodeMotion;
use super::problem::ContactProblem;
use super::problem::groups::LAST_TURN;
use super::sections::{OrientedSections, SectionShapes};
use super::system::CoupledSystem;
use crate::array_pool::PooledArray;
use crate::{StepReport, TimeInterval};
use nalgebra::Point3;
use rapunzel_rod_dynamic::StepVelocity;

/// What is left after an increment from a shape that is off by another one, in their product:
/// hardly ever more.
const CURVATURE: f64 = 100.0;

/// A substep: the part of a step at hand.
pub(super) struct Substep {
    /// Start and length of the substep, s.
    pub(super) time: f64,
    pub(super) dt: f64,
    /// Positions of all nodes at its start, m, world, in the order of the assembly.
    start: PooledArray<Point3<f64>>,
    /// Where it has been solved to when that was looked at last.
    ends: StepEnds,
    /// Mean velocities to where it has been solved to, of what the contacts at hand touch, unless
    /// it has been solved elsewhere since.
    mean: Option<FiberVelocities>,
    pub(super) work: ContactWork,
    /// Work of couples on fibres, J.
    pub(super) work_of_couples: f64,
    pub(super) report: StepReport,
    /// How far the fibres of each group have turned since they were linearised, rad; infinitely
    /// where that tells nothing of how they move now.
    pub(super) turns: Vec<f64>,
    /// By how much fibres may turn, rad, for a chord step to be as good as one of Newton's.
    chord: f64,
    /// By fibre, whether a list of the substep had contact points of it.
    pub(super) touching: Vec<bool>,
}

impl Substep {
    /// The substep that starts at `time` and takes `dt`, s, of fibres as they are now, whose
    /// segments may turn by `misspin`, rad/s, faster than is in balance.
    pub(super) fn new(time: f64, dt: f64, system: &CoupledSystem, misspin: f64) -> Self {
        let (start, ends) = (system.fibers.positions(), system.fibers.ends());
        let (work, report) = (ContactWork::default(), StepReport::default());
        let turns = vec![f64::INFINITY; system.fibers.groups.len()];
        let touching = vec![false; system.fibers.assembly().fibers().len()];
        let chord = (misspin * dt / CURVATURE).sqrt().min(LAST_TURN);
        let (mean, work_of_couples) = (None, 0.0);
        Self { time, dt, start, ends, mean, work, work_of_couples, report, turns, chord, touching }
    }

    /// By group, whether its fibres have turned so little since they were linearised that they need
    /// not be again: where contacts are `working`, so little that a chord step is as good as one of
    /// Newton's.
    pub(super) fn still(&self, working: &[bool]) -> Vec<bool> {
        let most = |working| if working { self.chord } else { LAST_TURN };
        self.turns.iter().zip(working).map(|(turn, &working)| *turn < most(working)).collect()
    }

    /// Notes the largest increments, rad, with which groups set out, but those of `others`.
    pub(super) fn note_set_out(&mut self, turns: &[f64], others: &[bool]) {
        let own = self.turns.iter_mut().zip(turns).zip(others);
        own.filter(|(_, other)| !**other).for_each(|((own, turn), _)| *own = *turn);
        self.note_moved(others);
    }

    /// Notes that groups moved, but these.
    fn note_moved(&mut self, unmoved: &[bool]) {
        self.ends.moved.iter_mut().zip(unmoved).for_each(|(moved, unmoved)| *moved |= !unmoved);
        self.mean = None;
    }

    /// Mean velocities to where it has been solved to, of what the contacts of a case touch.
    pub(super) fn mean(
        &mut self,
        system: &CoupledSystem,
        case: &ContactProblem,
    ) -> &FiberVelocities {
        self.mean.get_or_insert_with(|| case.velocities(system, StepVelocity::Mean))
    }

    /// Notes these velocities of what the contacts of another case touch.
    pub(super) fn set_mean(&mut self, mean: FiberVelocities) {
        self.mean = Some(mean);
    }

    /// Notes by what largest increments, rad, groups turned, but those that did not move. Those
    /// that were not `still` had been linearised. Returns the largest increment that may be
    /// followed by others: not of a chord step that leads as near to balance as may be.
    pub(super) fn note_turns(&mut self, turns: &[f64], unmoved: &[bool], still: &[bool]) -> f64 {
        self.note_moved(unmoved);
        let mut largest = 0.0_f64;
        let own = self.turns.iter_mut().zip(turns).zip(unmoved.iter().zip(still));
        for ((own, &turn), (_, &still)) in own.filter(|(_, (unmoved, _))| !**unmoved) {
            *own = if still { *own + turn } else { turn };
            if !still || *own > self.chord {
                largest = largest.max(turn);
            }
        }
        largest
    }

    /// Notes where impulses were replaced by others, which a linearisation did not know.
    pub(super) fn note_pressed(&mut self, pressed: &[bool]) {
        let own = self.turns.iter_mut().zip(pressed);
        own.filter(|(_, pressed)| **pressed).for_each(|(own, _)| *own = f64::INFINITY);
    }

    /// Notes the work of a case's contacts and couples; `slip` is the speed, m/s, up to which a
    /// contact sticks.
    pub(super) fn note_work(&mut self, system: &CoupledSystem, case: &ContactProblem, slip: f64) {
        let dt = self.dt;
        let mean = self.mean(system, case);
        let work = case.work(system, mean, dt, slip);
        (self.work_of_couples, self.work) = (case.work_of_couples(system, mean), work);
    }

    /// That all groups move.
    pub(super) fn all(&self) -> Vec<bool> {
        vec![false; self.turns.len()]
    }

    /// The motion of all nodes from the start to where the substep has been solved to.
    pub(super) fn motion<'a>(
        &'a mut self,
        system: &'a CoupledSystem<'_>,
        shapes: &'a SectionShapes,
    ) -> NodeMotion<'a> {
        system.fibers.renew(&mut self.ends, shapes);
        let (start, StepEnds { end, directors, .. }) = (&self.start, &self.ends);
        let layout = system.fibers.assembly().layout();
        let step = TimeInterval { start: self.time, length: self.dt };
        let sections = OrientedSections { shapes, directors };
        NodeMotion { layout, sections, start, end, step, sought: None }
    }
}
