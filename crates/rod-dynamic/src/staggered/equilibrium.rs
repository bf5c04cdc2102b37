//! Static solver: a step of infinite length.

use super::batch::StaggeredBatch;
use super::scheme::StepProblem;
use super::search::SearchOutcome;
use crate::{
    Conditions, End, Instant, Load, Rod, RodError, RodState, RodStepReport, SectionLaws, Steady,
    StepError,
};
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use rapunzel_fiber::so3;
use rapunzel_lanes::LANES;
use rapunzel_rod_static::{Chain, Piece, Properties, Target};
use thiserror::Error;

/// Length of the step in units of the rod's slowest bending time. Inertia has a part of `1e-6` in
/// Newton's matrix, and none in the balance: enough to hold modes that cost no energy, as when a
/// rod of circular section that has buckled from upright turns about its clamp. A longer step would
/// cost digits where the tip is held.
const LONG: f64 = 1e3;

/// Curvature that is added to leave a saddle of the energy, as the turn of the whole rod in rad.
const KICK: f64 = 0.05;
/// Number of saddles that are left before one is returned as the result.
const MAX_KICKS: usize = 4;

/// Why no equilibrium was found.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum EquilibriumError {
    /// Invalid rod, or invalid state to start from.
    #[error(transparent)]
    Rod(#[from] RodError),
    /// The loads make no sense, or Newton's method did not converge.
    #[error(transparent)]
    Solve(#[from] StepError),
}

/// The equilibrium of `rod` under `conditions` that minimising the energy from `start` leads to.
///
/// It is stable: from a saddle of the energy, as where a tall rod balances upright, and where
/// Newton's method fails, a [`Chain`] of the same segments leads down to a minimum nearby. (Moments
/// and follower forces at the ends have no energy, wind depends on the motion, and a [`Chain`] has
/// no pinned root: there the rod is bent a little and released again, and stability is not
/// claimed.) A free root is pinned at its position, since otherwise nothing holds the rod. The
/// state returned is at rest. Section laws are ignored: it is the equilibrium of the fibre with its
/// stiffness.
///
/// Second order in the length of the segments: the tip of a clamped horizontal hair of 100 segments
/// is off by `2.7e-4` of its length. Extrapolation from two meshes removes nearly all of that.
/// Cost: 4 to 8 Newton iterations.
///
/// # Errors
/// [`EquilibriumError::Rod`] for a start that does not fit the rod, [`EquilibriumError::Solve`]
/// for conditions that make no sense or a solve that does not converge, for which a start closer
/// to the equilibrium, or loads in smaller steps, help.
pub fn equilibrium(
    rod: &Rod,
    conditions: &Instant,
    start: &RodState,
) -> Result<(RodState, RodStepReport), EquilibriumError> {
    settled(rod, conditions, &[], start)
}

/// The [`equilibrium`] with additional forces on the nodes, N, world, one per node or none.
pub(super) fn settled(
    rod: &Rod,
    conditions: &Instant,
    node_forces: &[Vector3<f64>],
    start: &RodState,
) -> Result<(RodState, RodStepReport), EquilibriumError> {
    let mut undamped = rod.clone();
    undamped.damping_time = 0.0;
    undamped.laws = SectionLaws::Linear;
    let mut batch = StaggeredBatch::new(vec![undamped], 0.0)?;
    if !node_forces.is_empty() {
        batch.set_node_forces(0, node_forces)?;
    }
    let mut state = at_rest(start);
    let mut conditions = *conditions;
    if let End::Loaded { moment, .. } = conditions.root {
        conditions.root = End::Pinned { position: start.positions[0], moment };
    }
    let softest = rod.fiber.nodes().iter().map(|n| n.stiffness.min()).fold(f64::MAX, f64::min);
    let bending_time = (rod.fiber.mass() * rod.fiber.length().powi(3) / softest).sqrt();
    let mut total = RodStepReport::default();
    for kicks in 0..=MAX_KICKS {
        batch.set_state(0, &state)?;
        let mut reports = [RodStepReport::default()];
        let settled = batch.settle(LONG * bending_time, &[&Steady(conditions)], &mut reports);
        total.iterations += reports[0].iterations;
        total.residual = reports[0].residual;
        let stable = match settled {
            Ok(saddle) => {
                state = batch.state(0);
                state.time = start.time;
                !saddle
            }
            Err(StepError::NotConverged { .. }) if kicks == 0 => false,
            Err(error) => return Err(error.into()),
        };
        if stable || kicks == MAX_KICKS {
            break;
        }
        match least(rod, &conditions, node_forces, &state).filter(|_| kicks == 0) {
            Some(frames) => state.frames = frames,
            None => bend(&mut state, KICK * (kicks + 1) as f64),
        }
    }
    Ok((state, total))
}

/// The shape of `state` without its velocities.
pub(super) fn at_rest(state: &RodState) -> RodState {
    let mut state = state.clone();
    state.velocities.fill(Vector3::zeros());
    state.angular_velocities.fill(Vector3::zeros());
    state
}

/// Frames of the segments at the minimum of the energy that a [`Chain`] reaches from `state`.
/// `None` for conditions without an energy or not supported by a chain, and if it finds no minimum.
fn least(
    rod: &Rod,
    conditions: &Instant,
    node_forces: &[Vector3<f64>],
    state: &RodState,
) -> Option<Vec<Rotation3<f64>>> {
    let (fiber, last) = (&rod.fiber, state.frames.len());
    let End::Held(clamp) = conditions.root else { return None };
    if conditions.air.is_some() {
        return None;
    }
    let mut pieces: Vec<Piece> = fiber
        .nodes()
        .windows(2)
        .zip(fiber.segment_lengths())
        .map(|(ends, length)| {
            let density = 0.5 * (ends[0].linear_density + ends[1].linear_density);
            let properties = Properties {
                stiffness: 0.5 * (ends[0].stiffness + ends[1].stiffness),
                natural_curvature: 0.5 * (ends[0].natural_curvature + ends[1].natural_curvature),
                load: conditions.gravity * density + conditions.distributed,
            };
            Piece::uniform(*length, properties)
        })
        .collect();
    // Frames of the nodes: between those of the segments, and half a segment beyond the last.
    let frames: Vec<UnitQuaternion<f64>> = state.frames.iter().map(so3::quaternion).collect();
    let mut nodes = vec![clamp.rotation];
    nodes.extend(frames.windows(2).map(|pair| middle(&pair[0], &pair[1])));
    nodes.push(frames[last - 1] * nodes[last - 1].rotation_to(&frames[last - 1]));
    let mut held = None;
    match conditions.tip {
        End::Held(pose) => {
            nodes[last] = pose.rotation;
            held = Some(pose.translation.vector.into());
        }
        End::Pinned { position, moment } if moment == Load::ZERO => held = Some(position),
        End::Loaded { force: Load::World(force), moment } if moment == Load::ZERO => {
            let end = pieces.pop()?.with_end_load(force);
            pieces.push(end);
        }
        End::Pinned { .. } | End::Loaded { .. } | End::Supported(_) => return None,
    }
    let mut chain = Chain::new(&clamp, &pieces, last).ok()?;
    if !node_forces.is_empty() {
        let all = chain.forces().iter().zip(node_forces).map(|(a, b)| a + b).collect::<Vec<_>>();
        chain.set_forces(&all).ok()?;
    }
    chain.hold_tip_frame(matches!(conditions.tip, End::Held(_)));
    if let Some(place) = held {
        chain.set_targets(&[Target::held(last, place)]).ok()?;
    }
    let shape = chain.relax(&chain.shape_of(nodes).ok()?).ok()?.shape;
    let middles = shape.frames().windows(2).map(|pair| middle(&pair[0], &pair[1]));
    Some(middles.map(|frame| frame.to_rotation_matrix()).collect())
}

/// The rotation half way between two frames.
fn middle(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    a * a.rotation_to(b).powf(0.5)
}

/// Rotates the frames progressively toward the tip, by at most `angle` (rad), about an axis that is
/// no principal axis of the sections.
fn bend(state: &mut RodState, angle: f64) {
    let count = state.frames.len() as f64;
    for (e, frame) in state.frames.iter_mut().enumerate() {
        let turn = angle * (e as f64 + 0.5) / count;
        *frame *= so3::exp(&(turn * Vector3::new(0.8, 0.6, 0.0)));
    }
}

impl StaggeredBatch {
    /// Takes all fibres to equilibrium and to rest there; `dt` is the length of the step (s) whose
    /// inertia keeps Newton's matrix from being singular. Returns whether any fibre ended at a
    /// saddle of its energy instead of a minimum.
    fn settle(
        &mut self,
        dt: f64,
        conditions: &[&dyn Conditions],
        reports: &mut [RodStepReport],
    ) -> Result<bool, StepError> {
        self.skip_start();
        let saddle = self.working(|batch| {
            batch.begin(dt, conditions, reports)?;
            let saddle = batch.find_rest(dt, reports)?;
            batch.engine.commit(&[dt; LANES], &[true; LANES], StepProblem::Rest);
            Ok(saddle)
        })?;
        for fiber in 0..self.rods().len() {
            self.engine.stop(fiber);
        }
        Ok(saddle)
    }

    /// Solves for the equilibrium of all fibres. Returns whether any of them ended at a saddle.
    fn find_rest(&mut self, dt: f64, reports: &mut [RodStepReport]) -> Result<bool, StepError> {
        let count = self.rods().len();
        let mut out = [SearchOutcome::NONE; LANES];
        let mut wanted = [false; LANES];
        wanted[..count].fill(true);
        self.engine.attempt(&[dt; LANES], &wanted, StepProblem::Rest, &mut out);
        for fiber in 0..count {
            reports[fiber] = out[fiber].report();
            if !out[fiber].converged {
                return Err(StepError::NotConverged {
                    fiber,
                    time: self.time(),
                    dt,
                    residuals: out[fiber].residuals[..out[fiber].iterations].to_vec(),
                });
            }
        }
        Ok(out[..count].iter().any(|o| o.saddle))
    }
}
