//! The step of infinite length: a static solver.

use super::batch::StaggeredBatch;
use crate::{End, Instant, Rod, RodError, RodState, SectionLaws, Steady, StepError, StepReport};
use nalgebra::Vector3;
use rapunzel_fiber::so3;
use thiserror::Error;

/// Length of the step in units of the rod's slowest bending time. Inertia has a part of `1e-6` in
/// Newton's matrix, and none in the balance: enough to hold modes that cost no energy, as when a
/// rod of circular section that has buckled from upright turns about its clamp. A longer step would
/// cost digits where the tip is held.
const LONG: f64 = 1e3;

/// Curvature that is added to leave a saddle of the energy, as the turn of the whole rod in rad.
const KICK: f64 = 0.05;
/// How often a saddle is left before it is taken for the answer.
const MAX_KICKS: usize = 4;

/// Why no equilibrium was found.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum EquilibriumError {
    /// The rod or the state to start from makes no sense.
    #[error(transparent)]
    Rod(#[from] RodError),
    /// The loads make no sense, or Newton's method did not converge.
    #[error(transparent)]
    Solve(#[from] StepError),
}

/// The equilibrium of `rod` under `conditions` that minimising the energy from `start` leads to.
///
/// It is stable: where the Hessian is not positive definite, as for a tall rod that balances
/// upright, the rod is bent a little and let go again. (Moments and follower forces at the ends
/// have no energy, and stability is then not claimed.) A free root is taken as pinned where it is:
/// without that nothing holds the rod. The state returned is at rest. Laws of sections are not asked:
/// it is the equilibrium of the fibre with its stiffness.
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
) -> Result<(RodState, StepReport), EquilibriumError> {
    let mut undamped = rod.clone();
    undamped.damping_time = 0.0;
    undamped.laws = SectionLaws::Linear;
    let mut batch = StaggeredBatch::new(vec![undamped], 0.0)?;
    let mut state = start.clone();
    state.velocities.fill(Vector3::zeros());
    state.angular_velocities.fill(Vector3::zeros());
    let mut conditions = *conditions;
    if let End::Loaded { moment, .. } = conditions.root {
        conditions.root = End::Pinned { position: start.positions[0], moment };
    }
    let softest = rod.fiber.nodes().iter().map(|n| n.stiffness.min()).fold(f64::MAX, f64::min);
    let bending_time = (rod.fiber.mass() * rod.fiber.length().powi(3) / softest).sqrt();
    let mut total = StepReport::default();
    for kicks in 0..=MAX_KICKS {
        batch.set_state(0, &state)?;
        let mut reports = [StepReport::default()];
        let saddle = batch.settle(LONG * bending_time, &[&Steady(conditions)], &mut reports)?;
        total.iterations += reports[0].iterations;
        total.residual = reports[0].residual;
        state = batch.state(0);
        state.time = start.time;
        if !saddle || kicks == MAX_KICKS {
            break;
        }
        bend(&mut state, KICK * (kicks + 1) as f64);
    }
    Ok((state, total))
}

/// Turns the frames ever more toward the tip, about an axis that is special for no section.
fn bend(state: &mut RodState, angle: f64) {
    let count = state.frames.len() as f64;
    for (e, frame) in state.frames.iter_mut().enumerate() {
        let turn = angle * (e as f64 + 0.5) / count;
        *frame *= so3::exp(&(turn * Vector3::new(0.8, 0.6, 0.0)));
    }
}
