//! Arrays over all nodes of fibres, and what groups make of their parts of them.

use crate::contact_point::{BodyRef, ContactImpulse};
use crate::{FiberGroup, Fibers};
use nalgebra::{Point3, Vector3};
use rapunzel_rod_dynamic::{ImpulseResponse, RodError, StaggeredBatch, StepError};
use rayon::prelude::*;

impl Fibers<StaggeredBatch> {
    /// Positions of all nodes, in the order of the assembly; at the start of a step that is being
    /// solved.
    pub(super) fn positions(&self) -> Vec<Point3<f64>> {
        self.of_nodes(Point3::origin(), |batch, own| {
            each_node(batch, own, |(position, _)| position);
            Ok(())
        })
    }

    /// Velocities of all nodes at the start of the step.
    pub(super) fn velocities(&self) -> Vec<Vector3<f64>> {
        self.of_nodes(Vector3::zeros(), |batch, own| {
            each_node(batch, own, |(_, velocity)| velocity);
            Ok(())
        })
    }

    /// Mean velocities of all nodes over the step as it has been solved so far.
    pub(super) fn mean_velocities(&self) -> Vec<Vector3<f64>> {
        self.of_nodes(Vector3::zeros(), StaggeredBatch::mean_velocities)
    }

    /// Mean velocities of all nodes over the step with the increments of the last linearisation,
    /// m/s.
    pub(super) fn linear_velocities(&self) -> Vec<Vector3<f64>> {
        self.of_nodes(Vector3::zeros(), StaggeredBatch::linear_velocities)
    }

    fn of_nodes<T: Copy + Send + Sync>(
        &self,
        none: T,
        read: impl Fn(&StaggeredBatch, &mut [T]) -> Result<(), RodError> + Sync,
    ) -> Vec<T> {
        let layout = self.assembly().layout();
        let own = |group: &FiberGroup<StaggeredBatch>| {
            let mut own = vec![none; group.batch.nodes()];
            let done = read(&group.batch, &mut own);
            debug_assert!(done.is_ok(), "there is one for each node");
            own
        };
        let parts: Vec<_> = self.groups.par_iter().map(own).collect();
        let mut all = vec![none; layout.nodes()];
        for (group, part) in self.groups.iter().zip(&parts) {
            let mut rest = &part[..];
            for &fiber in &group.fibers {
                let range = layout.node_range(fiber);
                let (head, tail) = rest.split_at(range.len());
                all[range].copy_from_slice(head);
                rest = tail;
            }
        }
        all
    }

    /// What touches push on all nodes, N s.
    fn impulses(&self, pushes: impl Iterator<Item = ContactImpulse>) -> Vec<Vector3<f64>> {
        let layout = self.assembly().layout();
        let mut all = vec![Vector3::zeros(); layout.nodes()];
        for push in pushes {
            for (side, impulse) in [push.impulse, -push.impulse].into_iter().enumerate() {
                let BodyRef::Fiber(fiber) = push.sides[side] else { continue };
                let (segment, fraction) = (push.segments[side], push.fractions[side]);
                let node = layout.node_range(fiber as usize).start + segment as usize;
                all[node] += impulse * (1.0 - fraction);
                all[node + 1] += impulse * fraction;
            }
        }
        all
    }

    /// Lets every group do something, in parallel. Of several errors the first group's is told.
    pub(super) fn for_groups<T: Send>(
        &mut self,
        act: impl Fn(&mut FiberGroup<StaggeredBatch>) -> Result<T, StepError> + Sync + Send,
    ) -> Result<Vec<T>, StepError> {
        let results: Vec<_> = self.groups.par_iter_mut().map(act).collect();
        results.into_iter().collect()
    }

    /// Lets every group do something with the impulses on all its nodes, N s, in parallel. Of
    /// several errors the first group's is told.
    pub(super) fn with_impulses<T: Send>(
        &mut self,
        pushes: impl Iterator<Item = ContactImpulse>,
        act: impl Fn(&mut FiberGroup<StaggeredBatch>, &[Vector3<f64>]) -> Result<T, StepError>
        + Sync
        + Send,
    ) -> Result<Vec<T>, StepError> {
        let impulses = self.impulses(pushes);
        let ranges: Vec<_> = (0..self.assembly().layout().fibers())
            .map(|fiber| self.assembly().layout().node_range(fiber))
            .collect();
        self.for_groups(|group| {
            let own: Vec<_> = group
                .fibers
                .iter()
                .flat_map(|&fiber| impulses[ranges[fiber].clone()].iter().copied())
                .collect();
            act(group, &own)
        })
    }
}

/// Something of each node of a batch, by its position and velocity.
fn each_node<T>(
    batch: &StaggeredBatch,
    own: &mut [T],
    of: impl Fn((Point3<f64>, Vector3<f64>)) -> T,
) {
    let nodes = batch.nodes() / batch.rods().len();
    own.iter_mut().enumerate().for_each(|(k, own)| *own = of(batch.node(k / nodes, k % nodes)));
}
