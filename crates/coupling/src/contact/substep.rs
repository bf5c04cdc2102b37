use super::contact_work::ContactWork;
use super::detection::NodeMotion;
use super::system::CoupledSystem;
use crate::StepReport;
use crate::TimeInterval;
use nalgebra::{Point3, Vector3};

/// A substep: the part of a step at hand.
pub(super) struct Substep {
    /// Start and length of the substep, s.
    pub(super) time: f64,
    pub(super) dt: f64,
    pub(super) work: ContactWork,
    pub(super) report: StepReport,
}

impl Substep {
    /// Positions of all nodes, m, at the start, and at the end if they have these mean velocities,
    /// m/s.
    pub(super) fn ends(
        &self,
        system: &CoupledSystem,
        mean: &[Vector3<f64>],
    ) -> [Vec<Point3<f64>>; 2] {
        let start = system.fibers.positions();
        let end = start.iter().zip(mean).map(|(x, v)| x + v * self.dt).collect();
        [start, end]
    }

    /// The motion of all nodes between positions at the start and at the end.
    pub(super) fn motion<'a>(
        &self,
        system: &'a CoupledSystem<'_>,
        radii: &'a [f64],
        [start, end]: &'a [Vec<Point3<f64>>; 2],
    ) -> NodeMotion<'a> {
        let layout = system.fibers.assembly().layout();
        let step = TimeInterval { start: self.time, length: self.dt };
        NodeMotion { layout, radii, start, end, step }
    }
}
