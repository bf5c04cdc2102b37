//! Arrays over all nodes and segments of fibres, and what groups make of their parts of them.

use super::sections::SectionShapes;
use super::touched_parts::TouchedParts;
use crate::array_pool::PooledArray;
use crate::body_ref::BodyRef;
use crate::contact_point::ContactImpulse;
use crate::{FiberGroup, Fibers};
use nalgebra::{Matrix3, Point3, Vector3};
use rapunzel_lanes::LANES;
use rapunzel_rod_dynamic::{
    Impulses, Point, PointAction, RodError, StaggeredBatch, StepError, StepVelocity,
};
use rayon::prelude::*;
use std::ops::Range;

/// Velocities of all fibres, in the order of the assembly.
pub(super) struct FiberVelocities {
    /// Velocities of the nodes, m/s, world.
    pub(super) nodes: PooledArray<Vector3<f64>>,
    /// Angular velocities of the segments, rad/s, world.
    pub(super) spins: PooledArray<Vector3<f64>>,
}

/// Where the step under way has been solved to, in the order of the assembly.
pub(super) struct StepEnds {
    /// Positions of all nodes, m, world.
    pub(super) end: PooledArray<Point3<f64>>,
    /// Directors d1 and d2 of segments; none where all sections are round.
    pub(super) directors: Vec<[Vector3<f64>; 2]>,
    /// By group, whether its fibres have moved since.
    pub(super) moved: Vec<bool>,
}

/// Impulses on points of all fibres, group by group.
struct FiberImpulses {
    points: Vec<Point>,
    /// Impulses on these, N s, world.
    impulses: Vec<Vector3<f64>>,
    /// By group, where its own begin; behind these, how many there are.
    begins: Vec<usize>,
}

impl FiberImpulses {
    fn of_group(&self, group: usize) -> Impulses<'_> {
        let own = self.begins[group]..self.begins[group + 1];
        Impulses { points: &self.points[own.clone()], impulses: &self.impulses[own] }
    }
}

impl Fibers<StaggeredBatch> {
    /// Positions of all nodes, in the order of the assembly; at the start of a step that is being
    /// solved.
    pub(super) fn positions(&self) -> PooledArray<Point3<f64>> {
        let mut all = self.positions.take(self.assembly().layout().nodes(), Point3::origin());
        let range = |fiber| self.assembly().layout().node_range(fiber);
        let start = |_, batch: &StaggeredBatch, own: &mut [&mut [_]]| batch.start_positions(own);
        self.gather(&mut all, range, &self.every_group(), start);
        all
    }

    /// Room for where the step under way is solved to, before anything has been read of it.
    pub(super) fn ends(&self) -> StepEnds {
        let end = self.positions.take(self.assembly().layout().nodes(), Point3::origin());
        StepEnds { end, directors: Vec::new(), moved: vec![true; self.groups.len()] }
    }

    /// Reads where the step under way has been solved to, of the groups that have moved since.
    pub(super) fn renew(&self, ends: &mut StepEnds, shapes: &SectionShapes) {
        let StepEnds { end, directors, moved } = ends;
        self.read_ends(end, moved);
        self.read_directors(directors, shapes, moved);
        moved.fill(false);
    }

    /// Positions of all nodes where the step under way has been solved to, in the order of the
    /// assembly.
    pub(super) fn end_positions(&self) -> PooledArray<Point3<f64>> {
        let mut all = self.positions.take(self.assembly().layout().nodes(), Point3::origin());
        self.read_ends(&mut all, &self.every_group());
        all
    }

    fn read_ends(&self, all: &mut [Point3<f64>], groups: &[bool]) {
        let range = |fiber| self.assembly().layout().node_range(fiber);
        self.gather(all, range, groups, |_, batch, own| batch.end_positions(own));
    }

    /// That all groups are meant.
    fn every_group(&self) -> Vec<bool> {
        vec![true; self.groups.len()]
    }

    /// Velocities of the step under way, of all fibres or of what is `touched`.
    pub(super) fn velocities(
        &self,
        which: StepVelocity,
        touched: Option<&TouchedParts>,
    ) -> FiberVelocities {
        let layout = self.assembly().layout();
        let mut nodes = self.vectors.take(layout.nodes(), Vector3::zeros());
        let mut spins = self.vectors.take(layout.segments(), Vector3::zeros());
        if cfg!(debug_assertions) && touched.is_some() {
            // What is not touched is of another step.
            nodes.fill(Vector3::repeat(f64::NAN));
            spins.fill(Vector3::repeat(f64::NAN));
        }
        let groups = self.every_group();
        let range = |fiber| layout.node_range(fiber);
        self.gather(&mut nodes, range, &groups, |group, batch, own| {
            batch.velocities(which, touched.map(|parts| &parts.nodes[group][..]), own)
        });
        let range = |fiber| layout.segment_range(fiber);
        self.gather(&mut spins, range, &groups, |group, batch, own| {
            batch.spins(which, touched.map(|parts| &parts.segments[group][..]), own)
        });
        FiberVelocities { nodes, spins }
    }

    /// Directors d1 and d2 of all segments, where the step has been solved to; none where all
    /// sections are round.
    pub(super) fn directors(&self, shapes: &SectionShapes) -> Vec<[Vector3<f64>; 2]> {
        let mut all = Vec::new();
        self.read_directors(&mut all, shapes, &self.every_group());
        all
    }

    fn read_directors(
        &self,
        all: &mut Vec<[Vector3<f64>; 2]>,
        shapes: &SectionShapes,
        groups: &[bool],
    ) {
        if shapes.are_round() {
            return;
        }
        let layout = self.assembly().layout();
        all.resize(layout.segments(), [Vector3::zeros(); 2]);
        let range = |fiber| layout.segment_range(fiber);
        self.gather(all, range, groups, |_, batch, own| {
            for (lane, own) in own.iter_mut().enumerate() {
                let each = own.iter_mut().enumerate();
                each.for_each(|(segment, own)| *own = batch.section(lane, segment));
            }
            Ok(())
        });
    }

    /// Fills an array in the order of the assembly with what the marked groups, by their numbers,
    /// `read` of their fibres, into one slice for each: that of a fibre has its `range`.
    fn gather<T: Send>(
        &self,
        all: &mut [T],
        range: impl Fn(usize) -> Range<usize>,
        marked: &[bool],
        read: impl Fn(usize, &StaggeredBatch, &mut [&mut [T]]) -> Result<(), RodError> + Sync,
    ) {
        let fibers = self.assembly().fibers().len();
        let (mut slices, mut rest) = (Vec::with_capacity(fibers), all);
        for fiber in 0..fibers {
            let (own, behind) = rest.split_at_mut(range(fiber).len());
            slices.push(own);
            rest = behind;
        }
        let mut parts = Vec::with_capacity(self.groups.len());
        for (number, group) in self.groups.iter().enumerate().filter(|(number, _)| marked[*number])
        {
            let mut own: [&mut [T]; LANES] = Default::default();
            let lanes = own.iter_mut().zip(&group.fibers);
            lanes.for_each(|(own, fiber)| *own = std::mem::take(&mut slices[*fiber]));
            parts.push((number, group, own));
        }
        parts.into_par_iter().for_each(|(number, group, mut own)| {
            let done = read(number, &group.batch, &mut own[..group.fibers.len()]);
            debug_assert!(done.is_ok(), "there is a place for each");
        });
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
    fn impulses(&self, pushes: impl Iterator<Item = ContactImpulse> + Clone) -> FiberImpulses {
        let of_fibers = || pushes.clone().flat_map(|push| self.on_fibers(push));
        let mut begins = vec![0; self.groups.len() + 1];
        of_fibers().for_each(|(group, ..)| begins[group + 1] += 1);
        for group in 0..self.groups.len() {
            begins[group + 1] += begins[group];
        }
        let count = begins[self.groups.len()];
        let mut points = vec![Point::on_axis(0, 0, 0.0); count];
        let mut impulses = vec![Vector3::zeros(); count];
        let mut next = begins.clone();
        for (group, point, impulse) in of_fibers() {
            (points[next[group]], impulses[next[group]]) = (point, impulse);
            next[group] += 1;
        }
        FiberImpulses { points, impulses, begins }
    }

    /// What a touch pushes of each of its fibres: the group, the point, and the impulse, N s.
    fn on_fibers(
        &self,
        push: ContactImpulse,
    ) -> impl Iterator<Item = (usize, Point, Vector3<f64>)> {
        [push.impulse, -push.impulse].into_iter().enumerate().filter_map(move |(side, impulse)| {
            let BodyRef::Fiber(fiber) = push.sides[side] else { return None };
            let (group, lane) = self.lane(fiber as usize);
            let action = if push.couple {
                PointAction::Couple { lever: Matrix3::identity() }
            } else {
                PointAction::Force { fraction: push.fractions[side], arm: push.levers[side] }
            };
            #[expect(clippy::cast_possible_truncation, reason = "there are eight lanes")]
            Some((
                group,
                Point { fiber: lane as u32, segment: push.segments[side], action },
                impulse,
            ))
        })
    }

    /// Lets every group do something, in parallel, but those that are `still`, of which the default
    /// is told. Of several errors the first group's is told.
    pub(super) fn for_groups<T: Default + Send>(
        &mut self,
        still: &[bool],
        act: impl Fn(&mut FiberGroup<StaggeredBatch>) -> Result<T, StepError> + Sync + Send,
    ) -> Result<Vec<T>, StepError> {
        let parts = vec![(); self.groups.len()];
        self.in_parallel(still, parts, |group, ()| act(group))
    }

    /// Lets every group do something with the impulses on all its fibres, in parallel, but those
    /// that are `still`, of which the default is told. Of several errors the first group's is told.
    pub(super) fn with_impulses<T: Default + Send>(
        &mut self,
        still: &[bool],
        pushes: impl Iterator<Item = ContactImpulse> + Clone,
        act: impl Fn(&mut FiberGroup<StaggeredBatch>, Impulses) -> Result<T, StepError> + Sync + Send,
    ) -> Result<Vec<T>, StepError> {
        let all = self.impulses(pushes);
        let parts = (0..self.groups.len()).map(|group| all.of_group(group)).collect();
        self.in_parallel(still, parts, act)
    }

    /// Lets every group do something with its part, in parallel, but those that are `still`.
    fn in_parallel<P: Send, T: Default + Send>(
        &mut self,
        still: &[bool],
        parts: Vec<P>,
        act: impl Fn(&mut FiberGroup<StaggeredBatch>, P) -> Result<T, StepError> + Sync + Send,
    ) -> Result<Vec<T>, StepError> {
        let groups = self.groups.par_iter_mut().zip(still).zip(parts);
        let results = groups
            .map(|((group, still), part)| if *still { Ok(T::default()) } else { act(group, part) });
        let results: Vec<_> = results.collect();
        results.into_iter().collect()
    }
}
