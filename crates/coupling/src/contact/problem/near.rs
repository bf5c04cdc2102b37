//! Which contacts of a step may close.

use super::ContactProblem;
use super::parameters::ContactParameters;
use crate::contact::system::CoupledSystem;
use crate::contact::velocities::Velocities;
use crate::contact_point::ContactPoint;
use nalgebra::Vector3;
use rayon::prelude::*;

/// Openings are found anew where more than one in so many contacts may close.
const MANY: usize = 8;

impl ContactProblem {
    /// The contacts that may close where nodes are so fast, in their order.
    pub(super) fn near_where(&self, system: &CoupledSystem, nodes: &[Vector3<f64>]) -> Vec<usize> {
        let layout = system.fibers.assembly().layout();
        let all = || (0..self.laws.len()).collect();
        self.openings.as_ref().map_or_else(all, |openings| openings.near(layout, nodes))
    }

    /// The contacts that may close where nodes are so fast, in their order. If these are many of
    /// all, it is found anew how fast contacts open.
    pub(super) fn look(&mut self, system: &CoupledSystem, nodes: &Velocities) -> Vec<usize> {
        let near = self.near_where(system, nodes.nodes());
        let Some(openings) = self.openings.as_mut().filter(|_| near.len() > self.laws.len() / MANY)
        else {
            return near;
        };
        let one = |(point, law): (&ContactPoint, &ContactParameters)| law.opening(point, nodes);
        let speeds = self.points.par_iter().zip(&self.laws).map(one);
        openings.renew(speeds, nodes.nodes());
        openings.near(system.fibers.assembly().layout(), nodes.nodes())
    }
}
