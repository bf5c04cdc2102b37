use super::detect::Motion;
use super::touch::Touch;
use super::work::ContactWork;
use crate::{StepReport, World};
use nalgebra::{Point3, Vector3};

/// The part of a step at hand.
pub(super) struct Part {
    /// Its start and length, s.
    pub(super) time: f64,
    pub(super) dt: f64,
    /// Positions of all nodes at its start.
    pub(super) start: Vec<Point3<f64>>,
    pub(super) touches: Vec<Touch>,
    pub(super) work: ContactWork,
    pub(super) report: StepReport,
}

impl Part {
    /// Positions of all nodes at its end if they have these mean velocities.
    pub(super) fn end(&self, mean: &[Vector3<f64>]) -> Vec<Point3<f64>> {
        self.start.iter().zip(mean).map(|(x, v)| x + v * self.dt).collect()
    }

    pub(super) fn motion<'a>(
        &'a self,
        world: &'a World,
        radii: &'a [f64],
        end: &'a [Point3<f64>],
    ) -> Motion<'a> {
        let layout = world.assembly().layout();
        Motion { layout, radii, start: &self.start, end, time: self.time, dt: self.dt }
    }
}
