use crate::StepReport;
use crate::batch::RodBatch;
use crate::conditions::{BundleConditions, FiberConditions};
use nalgebra::{Isometry3, Quaternion, Rotation3, Translation3, UnitQuaternion};
use rapunzel_rod_dynamic::{
    self as rod, Conditions, Impulses, RodError, RodState, SectionLaws, StaggeredBatch, StepError,
};
use std::sync::Arc;

/// Numbers that are saved of a gripper of a fibre: whether it holds, and the pose.
const GRIP: usize = 8;

/// A batch of fibres with what acts on them: the unit of parallel work.
pub struct FiberGroup<B: RodBatch + ?Sized> {
    /// Indices of the fibres in the assembly, one per lane.
    pub fibers: Vec<usize>,
    /// The rods of these fibres.
    pub batch: Box<B>,
    /// What acts on each fibre.
    pub lanes: Vec<FiberConditions>,
}

impl<B: RodBatch + ?Sized> FiberGroup<B> {
    /// Moves all fibres of the group from `time` by `dt`, s.
    pub(crate) fn step(&mut self, time: f64, dt: f64) -> Result<StepReport, StepError> {
        let middle = self.load(time, dt)?;
        let during: Vec<_> = self.lanes.iter().map(|lane| lane.during(middle)).collect();
        let lanes: Vec<&dyn Conditions> = during.iter().map(|c| c as &dyn Conditions).collect();
        self.batch.step(dt, &lanes).map_err(|error| error.renumbered(|lane| self.fibers[lane]))
    }

    /// Gives sections the law of the climate at the end of the step from `time` by `dt`, s.
    fn follow_climate(&mut self, time: f64, dt: f64) -> Result<(), StepError> {
        let mut last: Option<(Arc<BundleConditions>, SectionLaws)> = None;
        for (lane, FiberConditions { bundle, .. }) in self.lanes.iter().enumerate() {
            let error = |why| StepError::Conditions {
                fiber: self.fibers[lane],
                what: "climate",
                time,
                why,
            };
            let laws = match &last {
                Some((of, laws)) if Arc::ptr_eq(of, bundle) => laws.clone(),
                _ => match bundle.laws(time + dt) {
                    None => continue,
                    Some(laws) => laws.map_err(|_| error("the law of hair is not known in it"))?,
                },
            };
            last = Some((Arc::clone(bundle), laws.clone()));
            let set = self.batch.set_laws(lane, laws);
            set.map_err(|_| error("laws must remember alike"))?;
        }
        Ok(())
    }

    /// Sets the forces on nodes for the step from `time` by `dt`, s. Returns its middle.
    pub(crate) fn load(&mut self, time: f64, dt: f64) -> Result<f64, StepError> {
        let middle = time + 0.5 * dt;
        self.follow_climate(time, dt)?;
        self.grip(middle);
        self.hold_nodes(time, dt)?;
        self.put_forces(middle)?;
        Ok(middle)
    }

    /// Lets grippers take nodes as they are now, and let them go, for the step whose middle is at a
    /// time, s.
    fn grip(&mut self, middle: f64) {
        for (lane, conditions) in self.lanes.iter_mut().enumerate() {
            conditions.grip(middle, |node| pose(&self.batch.state(lane), node));
        }
    }

    /// Holds inner nodes that are gripped where they are to be after the step from `time` by `dt`,
    /// s.
    fn hold_nodes(&mut self, time: f64, dt: f64) -> Result<(), StepError> {
        for (lane, conditions) in self.lanes.iter().enumerate() {
            // One that is let go may be held by another gripper.
            let nodes = || conditions.gripped_nodes(time + dt);
            for (node, place) in nodes() {
                if place.is_none() && nodes().any(|(other, held)| other == node && held.is_some()) {
                    continue;
                }
                self.batch.hold_node(lane, node, place, dt).map_err(|_| StepError::Conditions {
                    fiber: self.fibers[lane],
                    what: "gripper",
                    time,
                    why: "must be of an inner node of a fibre by the staggered chain",
                })?;
            }
        }
        Ok(())
    }

    /// Appends all numbers that change.
    pub(crate) fn save(&self, numbers: &mut Vec<f64>) {
        self.batch.save(numbers);
        for taken in self.lanes.iter().flat_map(FiberConditions::grips) {
            let pose = taken.unwrap_or_else(Isometry3::identity);
            numbers.push(f64::from(taken.is_some()));
            numbers.extend(pose.translation.vector.iter().chain(pose.rotation.coords.iter()));
        }
    }

    /// Goes back to saved numbers.
    pub(crate) fn restore(&mut self, numbers: &[f64]) -> Result<(), RodError> {
        let count: usize = self.lanes.iter().map(|lane| lane.grips().count()).sum();
        let (expected, found) = (GRIP * count, numbers.len());
        let Some(own) = found.checked_sub(expected) else {
            return Err(RodError::Length { what: "poses of grippers", expected, found });
        };
        let (batch, grips) = numbers.split_at(own);
        self.batch.restore(batch)?;
        let mut grips = grips.chunks_exact(GRIP).map(|numbers| {
            let [held, x, y, z, i, j, k, w] = *numbers else { return None };
            let turn = UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k));
            (held > 0.0).then(|| Isometry3::from_parts(Translation3::new(x, y, z), turn))
        });
        for lane in &mut self.lanes {
            let count = lane.grips().count();
            lane.taken = grips.by_ref().take(count).collect();
        }
        Ok(())
    }

    /// Puts the forces of the scene at a time (s) on the nodes.
    pub(crate) fn put_forces(&mut self, time: f64) -> Result<(), StepError> {
        for (lane, conditions) in self.lanes.iter().enumerate() {
            if let Some(forces) = conditions.node_forces(time) {
                self.batch.set_node_forces(lane, &forces).map_err(|_| StepError::Conditions {
                    fiber: self.fibers[lane],
                    what: "node forces",
                    time,
                    why: "must be finite",
                })?;
            }
        }
        Ok(())
    }
}

/// Pose of the tip of a rod, the frame of its last segment continued over half of it.
fn tip(state: &RodState) -> Isometry3<f64> {
    let n = state.frames.len();
    let length = (state.positions[n] - state.positions[n - 1]).norm();
    let turn = 0.75 * state.curvatures[n] + 0.25 * state.curvatures[n - 1];
    let frame = state.frames[n - 1] * Rotation3::new(0.5 * length * turn);
    let frame = UnitQuaternion::from_rotation_matrix(&frame);
    Isometry3::from_parts(state.positions[n].into(), frame)
}

/// Pose of a node of a rod: of the tip and the root the frame of the segment there, continued over
/// half of it, of others without a rotation.
fn pose(state: &RodState, node: usize) -> Isometry3<f64> {
    let n = state.frames.len();
    if node == n {
        return tip(state);
    }
    let place = state.positions[node];
    if node > 0 {
        return Isometry3::translation(place.x, place.y, place.z);
    }
    let length = (state.positions[1] - place).norm();
    let turn = 0.75 * state.curvatures[0] + 0.25 * state.curvatures[1];
    let frame = state.frames[0] * Rotation3::new(-0.5 * length * turn);
    Isometry3::from_parts(place.into(), UnitQuaternion::from_rotation_matrix(&frame))
}

/// The parts of a step of fibres in contact.
impl FiberGroup<StaggeredBatch> {
    /// Sets out on the step from `time` by `dt`, s, with impulses on all fibres at its start,
    /// without solving it; without impulses the first iteration of Newton's method is taken at
    /// once. Returns the largest increment, rad, infinite where none has been taken.
    pub(crate) fn set_out(
        &mut self,
        time: f64,
        dt: f64,
        impulses: Impulses,
    ) -> Result<f64, StepError> {
        let middle = self.load(time, dt)?;
        let during: Vec<_> = self.lanes.iter().map(|lane| lane.during(middle)).collect();
        let lanes: Vec<&dyn Conditions> = during.iter().map(|c| c as &dyn Conditions).collect();
        let mut reports = [rod::RodStepReport::default(); StaggeredBatch::MAX_FIBERS];
        let done = if impulses.is_empty() {
            self.batch.set_out_free(dt, &lanes, &mut reports)
        } else {
            let set = self.batch.set_out(dt, &lanes, impulses, &mut reports);
            set.map(|()| f64::INFINITY)
        };
        done.map_err(|error| error.renumbered(|lane| self.fibers[lane]))
    }

    /// Lets fibres that fly, and that `touches` tells, by their numbers, to touch something, bear
    /// impulses from the next step on. Returns whether there are any.
    pub(crate) fn land(&mut self, touches: impl Fn(usize) -> bool) -> bool {
        let mut any = false;
        for (lane, &fiber) in self.fibers.iter().enumerate() {
            if !self.batch.bears(lane) && touches(fiber) {
                self.batch.set_bearing(lane, true);
                any = true;
            }
        }
        any
    }

    /// Lets fibres fly from the next step on of which `touches` tells, by their numbers, that they
    /// touch nothing.
    pub(crate) fn take_off(&mut self, touches: impl Fn(usize) -> bool) {
        for (lane, &fiber) in self.fibers.iter().enumerate() {
            if !touches(fiber) {
                self.batch.set_bearing(lane, false);
            }
        }
    }

    /// Puts other impulses in place of those before, without moving anything. Returns whether they
    /// are others.
    pub(crate) fn press(&mut self, impulses: Impulses) -> Result<bool, StepError> {
        self.batch.press(impulses).map_err(|error| error.renumbered(|lane| self.fibers[lane]))
    }

    /// Solves Newton's equations of the step; returns the largest increment, rad.
    pub(crate) fn linearize(&mut self) -> Result<f64, StepError> {
        self.batch.linearize().map_err(|error| error.renumbered(|lane| self.fibers[lane]))
    }

    /// Takes the increments, with other impulses.
    pub(crate) fn advance(&mut self, impulses: Impulses) -> Result<f64, StepError> {
        self.batch.advance(impulses).map_err(|error| error.renumbered(|lane| self.fibers[lane]))
    }
}
