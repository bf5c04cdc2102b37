//! What one thread does at a time: some bodies, and some contacts, which need not be between them.

use super::admm_state::AdmmState;
use super::anderson::{AndersonHistory, AndersonUpdate, IterationKind, ResidualProducts};
use super::contact_group::ContactGroup;
use crate::residual::ResidualSums;
use crate::{Body, ContactError, VectorLanes};
use nalgebra::Vector3;
use rapunzel_lanes::LANES;
use std::ops::Range;

/// Buffers of a thread, used by all parts that it works on.
#[derive(Default)]
pub(super) struct AdmmWorkspace {
    /// Impulses that bodies are to answer, by point, N s, world.
    point_impulses: Vec<Vector3<f64>>,
    /// Velocities with which bodies answer, by point, m/s, world.
    point_velocities: Vec<Vector3<f64>>,
    /// Increments of the state in a step of the acceleration, times the roots of the metric.
    pub(super) increments: Vec<f64>,
    /// State as the acceleration mixes it.
    pub(super) mixed: Vec<f64>,
}

/// Some bodies and some contacts.
pub(super) struct AdmmPart<'a, 'b> {
    bodies: &'a mut [&'b mut dyn Body],
    /// Points of the bodies.
    points: Range<usize>,
    /// State at the start of a step of the acceleration, by side, m/s, world.
    step_start: Vec<Vector3<f64>>,
    splitting_history: &'a mut AndersonHistory,
    pub(super) descent_history: &'a mut AndersonHistory,
    /// Products of the last step of the acceleration.
    pub(super) products: ResidualProducts,
    pub(super) contacts: Range<usize>,
    /// Impulses as they were given and as the solver returns them, N s, in the contacts' frames.
    caller_impulses: &'a mut [Vector3<f64>],
    pub(super) groups: Vec<ContactGroup>,
    /// Impulses in the frames of the contacts, by group, N s.
    pub(super) impulses: Vec<VectorLanes<f64>>,
    /// Relative velocities for which the impulses obey the law, by group, m/s, in the contacts'
    /// frames.
    pub(super) wanted: Vec<VectorLanes<f64>>,
    pub(super) sums: ResidualSums,
    /// Error of a body that does not take the metric.
    pub(super) body_error: Option<ContactError>,
}

impl<'a, 'b> AdmmPart<'a, 'b> {
    /// A part of the `bodies`, which have the `points`, and of the `contacts`, which bear the
    /// `impulses`.
    pub(super) fn new(
        state: &AdmmState,
        (bodies, points): (&'a mut [&'b mut dyn Body], Range<usize>),
        (caller_impulses, contacts): (&'a mut [Vector3<f64>], Range<usize>),
        [splitting_history, descent_history]: [&'a mut AndersonHistory; 2],
    ) -> Self {
        let AdmmState { sides, metric, .. } = state;
        let group = |start: usize| {
            let part = start..contacts.end.min(start + LANES);
            let own = &state.contacts[part.clone()];
            let (mut at_points, mut at_sides) = ([[0; LANES]; 2], [[0; LANES]; 2]);
            for (lane, (contact, sides)) in own.iter().zip(sides.of_contacts(&part)).enumerate() {
                let points = [contact.first, contact.second.unwrap_or(metric.len())];
                for side in 0..2 {
                    at_points[side][lane] = index(points[side]);
                    at_sides[side][lane] = sides[side];
                }
            }
            let velocities = own.iter().map(|contact| state.relative_velocity(contact));
            let impulses = &caller_impulses[start - contacts.start..];
            let responses = own.iter().map(|contact| state.metric_response(contact));
            let masses = own.iter().map(|contact| state.error_masses(contact));
            let indices = [at_points, at_sides];
            ContactGroup::new(own, velocities, impulses, responses, masses, indices)
        };
        let groups: Vec<_> = contacts.clone().step_by(LANES).map(group).collect();
        Self {
            impulses: groups.iter().map(|group| group.impulses).collect(),
            groups,
            products: ResidualProducts::default(),
            wanted: Vec::new(),
            sums: ResidualSums::default(),
            body_error: None,
            step_start: Vec::new(),
            bodies,
            points,
            splitting_history,
            descent_history,
            contacts,
            caller_impulses,
        }
    }

    /// Adds the metric to the bodies, and sets the state to `h = v - r / R` by side.
    pub(super) fn initialize(&mut self, state: &AdmmState) {
        let added = |point: usize| state.metric[point] * state.sides.at_point(point).len() as f64;
        let weights: Vec<f64> = self.points.clone().map(added).collect();
        let mut rest = &weights[..];
        for body in &mut *self.bodies {
            let (own, behind) = rest.split_at(body.points());
            rest = behind;
            if let Err(error) = body.set_weights(own) {
                self.body_error.get_or_insert(error);
            }
        }
        self.wanted.resize(self.groups.len(), VectorLanes::default());
        for point in self.points.clone() {
            let (v, mass) = (state.velocity_changes.get(point), state.metric[point]);
            for side in state.sides.at_point(point) {
                state.h.set(side, &(v - state.side_impulse(side) / mass));
            }
        }
    }

    /// Lets the bodies move as near to `2 z - h` as they can, and relaxes the state,
    /// `h <- h + alpha (v - z)`.
    pub(super) fn respond(
        &mut self,
        state: &AdmmState,
        starts_step: bool,
        kind: IterationKind,
        keeps_velocities: bool,
        workspace: &mut AdmmWorkspace,
    ) {
        let AdmmState { sides, metric, h, .. } = state;
        // With z = h + r / R the impulse R (2 z - h) on a side is R h + 2 r.
        let impulse_at = |point: usize| {
            let of_side = |side| h.get(side) * metric[point] + state.side_impulse(side) * 2.0;
            sides.at_point(point).map(of_side).sum()
        };
        self.ask_bodies(impulse_at, workspace, |body, impulses, velocities| {
            body.weighted_respond(impulses, velocities);
        });
        if starts_step {
            self.step_start.clear();
        }
        let ends_step = matches!(kind, IterationKind::EndOfStep(_));
        if ends_step {
            self.splitting_history.image_mut().clear();
            workspace.increments.clear();
        }
        let first = state.sides.at_points(&self.points).start;
        for (point, v) in self.points.clone().zip(&workspace.point_velocities) {
            let lightness = 1.0 / metric[point];
            let root = if ends_step { metric[point].sqrt() } else { 0.0 };
            for side in sides.at_point(point) {
                let before = h.get(side);
                let z = before + state.side_impulse(side) * lightness;
                let next = before + (v - z) * state.relaxation;
                if starts_step {
                    self.step_start.push(before);
                }
                if ends_step {
                    self.splitting_history.image_mut().extend_from_slice(next.as_slice());
                    let increment = (next - self.step_start[side - first]) * root;
                    workspace.increments.extend_from_slice(increment.as_slice());
                } else {
                    h.set(side, &next);
                }
            }
            if keeps_velocities {
                state.velocity_changes.set(point, v);
            }
        }
        if let IterationKind::EndOfStep(slot) = kind {
            self.products = self.splitting_history.record(&workspace.increments, slot);
        }
    }

    /// Sets the state to what the acceleration makes of the last steps.
    pub(super) fn extrapolate(
        &mut self,
        state: &AdmmState,
        update: &AndersonUpdate,
        workspace: &mut AdmmWorkspace,
    ) {
        let mixed = self.splitting_history.apply(update, &mut workspace.mixed);
        let mixed = mixed.as_chunks::<3>().0;
        for (side, next) in state.sides.at_points(&self.points).zip(mixed) {
            state.h.set(side, &(*next).into());
        }
    }

    /// Evaluates the velocities that the impulses cause, without the metric.
    pub(super) fn eval_velocities(&mut self, state: &AdmmState, workspace: &mut AdmmWorkspace) {
        let impulse_at = |point: usize| {
            let mut sides = state.sides.at_point(point).map(|side| state.side_impulse(side));
            let first = sides.next().unwrap_or_default();
            sides.fold(first, |sum, impulse| sum + impulse)
        };
        self.ask_bodies(impulse_at, workspace, |body, impulses, velocities| {
            body.respond(impulses, velocities);
        });
        for (point, v) in self.points.clone().zip(&workspace.point_velocities) {
            state.velocity_changes.set(point, v);
        }
    }

    /// Returns the impulses to the caller.
    pub(super) fn return_impulses(&mut self) {
        let all = self.impulses.iter().flat_map(|[n, s, t]| n.iter().zip(s).zip(t));
        for (returned, ((n, s), t)) in self.caller_impulses.iter_mut().zip(all) {
            *returned = Vector3::new(*n, *s, *t);
        }
    }

    /// Lets all bodies answer an impulse at each point, N s, world.
    fn ask_bodies(
        &mut self,
        impulse_at: impl Fn(usize) -> Vector3<f64>,
        workspace: &mut AdmmWorkspace,
        answer: impl Fn(&mut dyn Body, &[Vector3<f64>], &mut [Vector3<f64>]),
    ) {
        let AdmmWorkspace { point_impulses, point_velocities, .. } = workspace;
        point_impulses.clear();
        point_impulses.extend(self.points.clone().map(impulse_at));
        point_velocities.resize(point_impulses.len(), Vector3::zeros());
        let mut start = 0;
        for body in &mut *self.bodies {
            let own = start..start + body.points();
            answer(&mut **body, &point_impulses[own.clone()], &mut point_velocities[own.clone()]);
            start = own.end;
        }
    }
}

/// A point's number as contact groups keep it.
#[expect(clippy::cast_possible_truncation, reason = "so many points fit nowhere")]
fn index(point: usize) -> u32 {
    point as u32
}
