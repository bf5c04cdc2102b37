//! Arrays over all nodes and segments of fibres, and what groups make of their parts of them.

use super::sections::SectionShapes;
use crate::contact_point::{BodyRef, ContactImpulse};
use crate::{FiberGroup, Fibers};
use nalgebra::{Point3, Vector3};
use rapunzel_rod_dynamic::{ImpulseResponse, Impulses, RodError, StaggeredBatch, StepError};
use rayon::prelude::*;
use std::ops::Range;

/// Velocities of all fibres, in the order of the assembly.
pub(super) struct FiberVelocities {
    /// Velocities of the nodes, m/s, world.
    pub(super) nodes: Vec<Vector3<f64>>,
    /// Angular velocities of the segments, rad/s, world.
    pub(super) spins: Vec<Vector3<f64>>,
}

/// Nodes at the start and at the end of a step, in the order of the assembly.
pub(super) struct StepEnds {
    /// Positions at the start, m, world.
    pub(super) start: Vec<Point3<f64>>,
    /// Positions at the end, m, world.
    pub(super) end: Vec<Point3<f64>>,
    /// Directors d1 and d2 of segments at the end; none where all sections are round.
    pub(super) directors: Vec<[Vector3<f64>; 2]>,
}

/// Impulses on all fibres, in the order of the assembly.
struct FiberImpulses {
    /// Impulses on the nodes, N s, world.
    nodes: Vec<Vector3<f64>>,
    /// Moments of impulses on the segments about their axes, N m s, world.
    segments: Vec<Vector3<f64>>,
}

impl Fibers<StaggeredBatch> {
    /// Positions of all nodes, in the order of the assembly; at the start of a step that is being
    /// solved.
    pub(super) fn positions(&self) -> Vec<Point3<f64>> {
        self.of_nodes(Point3::origin(), |batch, own| {
            each_node(batch, own, |(position, _)| position);
            Ok(())
        })
    }

    /// Velocities at the start of the step.
    pub(super) fn velocities(&self) -> FiberVelocities {
        let nodes = self.of_nodes(Vector3::zeros(), |batch, own| {
            each_node(batch, own, |(_, velocity)| velocity);
            Ok(())
        });
        FiberVelocities {
            nodes,
            spins: self.of_segments(Vector3::zeros(), StaggeredBatch::start_spins),
        }
    }

    /// Mean velocities over the step as it has been solved so far.
    pub(super) fn mean_velocities(&self) -> FiberVelocities {
        FiberVelocities {
            nodes: self.of_nodes(Vector3::zeros(), StaggeredBatch::mean_velocities),
            spins: self.of_segments(Vector3::zeros(), StaggeredBatch::mean_spins),
        }
    }

    /// Mean velocities over the step with the increments of the last linearisation.
    pub(super) fn linear_velocities(&self) -> FiberVelocities {
        FiberVelocities {
            nodes: self.of_nodes(Vector3::zeros(), StaggeredBatch::linear_velocities),
            spins: self.of_segments(Vector3::zeros(), StaggeredBatch::linear_spins),
        }
    }

    /// Directors d1 and d2 of all segments, where the step has been solved to; none where all
    /// sections are round.
    pub(super) fn directors(&self, shapes: &SectionShapes) -> Vec<[Vector3<f64>; 2]> {
        if shapes.are_round() {
            return Vec::new();
        }
        self.of_segments([Vector3::zeros(); 2], |batch, own| {
            let segments = own.len() / batch.rods().len();
            let each = own.iter_mut().enumerate();
            each.for_each(|(k, own)| *own = batch.section(k / segments, k % segments));
            Ok(())
        })
    }

    fn of_nodes<T: Copy + Send + Sync>(
        &self,
        none: T,
        read: impl Fn(&StaggeredBatch, &mut [T]) -> Result<(), RodError> + Sync,
    ) -> Vec<T> {
        let layout = self.assembly().layout();
        let all = vec![none; layout.nodes()];
        self.gathered(all, none, StaggeredBatch::nodes, read, |fiber| layout.node_range(fiber))
    }

    fn of_segments<T: Copy + Send + Sync>(
        &self,
        none: T,
        read: impl Fn(&StaggeredBatch, &mut [T]) -> Result<(), RodError> + Sync,
    ) -> Vec<T> {
        let layout = self.assembly().layout();
        let all = vec![none; layout.segments()];
        let segments = |batch: &StaggeredBatch| batch.nodes() - batch.rods().len();
        self.gathered(all, none, segments, read, |fiber| layout.segment_range(fiber))
    }

    /// What groups `read` of the nodes or segments of their fibres, of which a batch has a `count`;
    /// those of a fibre have their `range` of all.
    fn gathered<T: Copy + Send + Sync>(
        &self,
        mut all: Vec<T>,
        none: T,
        count: impl Fn(&StaggeredBatch) -> usize + Sync,
        read: impl Fn(&StaggeredBatch, &mut [T]) -> Result<(), RodError> + Sync,
        range: impl Fn(usize) -> Range<usize>,
    ) -> Vec<T> {
        let own = |group: &FiberGroup<StaggeredBatch>| {
            let mut own = vec![none; count(&group.batch)];
            let done = read(&group.batch, &mut own);
            debug_assert!(done.is_ok(), "there is one for each");
            own
        };
        let parts: Vec<_> = self.groups.par_iter().map(own).collect();
        for (group, part) in self.groups.iter().zip(&parts) {
            let mut rest = &part[..];
            for &fiber in &group.fibers {
                let range = range(fiber);
                let (head, tail) = rest.split_at(range.len());
                all[range].copy_from_slice(head);
                rest = tail;
            }
        }
        all
    }

    /// By fibre, the part whose surface contacts turn in the step under way, in segments from the
    /// root: between its clamps, the sections in these left out.
    pub(super) fn turning_parts(&self) -> Vec<Range<f64>> {
        let layout = self.assembly().layout();
        let part = |fiber: usize| {
            let (group, lane) = self.lane(fiber);
            let end = layout.segment_range(fiber).len() as f64;
            match self.groups[group].batch.clamps(lane) {
                [true, true] => f64::MIN_POSITIVE..end,
                [true, false] => f64::MIN_POSITIVE..f64::INFINITY,
                [false, true] => 0.0..end,
                [false, false] => 0.0..f64::INFINITY,
            }
        };
        (0..layout.fibers()).map(part).collect()
    }

    /// What touches push on all fibres.
    fn impulses(&self, pushes: impl Iterator<Item = ContactImpulse>) -> FiberImpulses {
        let layout = self.assembly().layout();
        let mut nodes = vec![Vector3::zeros(); layout.nodes()];
        let mut segments = vec![Vector3::zeros(); layout.segments()];
        for push in pushes {
            for (side, impulse) in [push.impulse, -push.impulse].into_iter().enumerate() {
                let BodyRef::Fiber(fiber) = push.sides[side] else { continue };
                let (fiber, segment) = (fiber as usize, push.segments[side] as usize);
                let node = layout.node_range(fiber).start + segment;
                nodes[node] += impulse * (1.0 - push.fractions[side]);
                nodes[node + 1] += impulse * push.fractions[side];
                let moment = push.levers[side].cross(&impulse);
                segments[layout.segment_range(fiber).start + segment] += moment;
            }
        }
        FiberImpulses { nodes, segments }
    }

    /// Lets every group do something, in parallel, but those that are `still`, of which the default
    /// is told. Of several errors the first group's is told.
    pub(super) fn for_groups<T: Default + Send>(
        &mut self,
        still: &[bool],
        act: impl Fn(&mut FiberGroup<StaggeredBatch>) -> Result<T, StepError> + Sync + Send,
    ) -> Result<Vec<T>, StepError> {
        let groups = self.groups.par_iter_mut().zip(still);
        let results =
            groups.map(|(group, still)| if *still { Ok(T::default()) } else { act(group) });
        let results: Vec<_> = results.collect();
        results.into_iter().collect()
    }

    /// Lets every group do something with the impulses on all its fibres, in parallel, but those
    /// that are `still`, of which the default is told. Of several errors the first group's is told.
    pub(super) fn with_impulses<T: Default + Send>(
        &mut self,
        still: &[bool],
        pushes: impl Iterator<Item = ContactImpulse>,
        act: impl Fn(&mut FiberGroup<StaggeredBatch>, Impulses) -> Result<T, StepError> + Sync + Send,
    ) -> Result<Vec<T>, StepError> {
        let FiberImpulses { nodes, segments } = self.impulses(pushes);
        let layout = self.assembly().layout();
        let ranges: Vec<_> = (0..layout.fibers())
            .map(|fiber| (layout.node_range(fiber), layout.segment_range(fiber)))
            .collect();
        self.for_groups(still, |group| {
            let (mut of_nodes, mut of_segments) = (Vec::new(), Vec::new());
            for &fiber in &group.fibers {
                let (own, between) = ranges[fiber].clone();
                of_nodes.extend_from_slice(&nodes[own]);
                of_segments.extend_from_slice(&segments[between]);
            }
            act(group, Impulses { nodes: &of_nodes, segments: &of_segments })
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
