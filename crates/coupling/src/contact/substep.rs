use super::contact_work::ContactWork;
use super::detection::NodeMotion;
use super::node_arrays::StepEnds;
use super::sections::{OrientedSections, SectionShapes};
use super::system::CoupledSystem;
use crate::StepReport;
use crate::TimeInterval;

/// A substep: the part of a step at hand.
pub(super) struct Substep {
    /// Start and length of the substep, s.
    pub(super) time: f64,
    pub(super) dt: f64,
    pub(super) work: ContactWork,
    /// Work of couples on fibres, J.
    pub(super) work_of_couples: f64,
    pub(super) report: StepReport,
    /// Largest last increment of Newton's method, by group, rad.
    pub(super) turns: Vec<f64>,
}

impl Substep {
    /// The substep that starts at `time` and takes `dt`, s, of a number of groups of fibres.
    pub(super) fn new(time: f64, dt: f64, groups: usize) -> Self {
        let (work, report) = (ContactWork::default(), StepReport::default());
        let turns = vec![f64::INFINITY; groups];
        Self { time, dt, work, work_of_couples: 0.0, report, turns }
    }

    /// That no group is still.
    pub(super) fn all(&self) -> Vec<bool> {
        vec![false; self.turns.len()]
    }

    /// The motion of all nodes between positions at the start and at the end.
    pub(super) fn motion<'a>(
        &self,
        system: &'a CoupledSystem<'_>,
        shapes: &'a SectionShapes,
        StepEnds { start, end, directors }: &'a StepEnds,
    ) -> NodeMotion<'a> {
        let layout = system.fibers.assembly().layout();
        let step = TimeInterval { start: self.time, length: self.dt };
        NodeMotion { layout, sections: OrientedSections { shapes, directors }, start, end, step }
    }
}
