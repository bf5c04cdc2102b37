//! The phases of the method, and what a part does in each.

use super::admm_part::{AdmmPart, AdmmWorkspace};
use super::admm_state::AdmmState;
use super::anderson::{AndersonUpdate, HistorySlot, IterationKind};
use super::contact_kernel::ContactKernel;
use super::phase_pool::Leader;
use crate::Report;
use crate::residual::ResidualSums;

/// Phase of the method, done by all parts before the next begins.
pub(super) enum Phase {
    /// Adds the metric to the bodies, and begins where the contacts' impulses cause the velocities
    /// that have been evaluated.
    Initialize,
    /// Solves every contact by itself, and keeps the velocities it wants if these are looked at.
    Prox { keeps_velocities: bool },
    /// Lets the bodies answer, and keeps their velocities if these are looked at.
    Respond { starts_step: bool, kind: IterationKind, keeps_velocities: bool },
    /// Sets the state to what the acceleration makes of the last steps.
    Extrapolate(AndersonUpdate),
    /// Evaluates how far what the contacts want is from what the bodies do.
    EvalSplitting,
    /// Evaluates the velocities that the impulses cause.
    EvalVelocities,
    /// Evaluates how far these velocities are from the law.
    EvalResidual,
    /// Finds where the gradient leads, and what the acceleration needs of it; also how far the
    /// velocities are from the law if `evaluates_residual`.
    DescentGradient { evaluates_residual: bool, slot: Option<HistorySlot> },
    /// Takes the accelerated step of the descent, back into the cones.
    DescentUpdate(AndersonUpdate),
    /// Returns the impulses to the caller.
    ReturnImpulses,
}

impl Phase {
    /// Does this phase's work of one part.
    pub(super) fn run(
        &self,
        part: &mut AdmmPart<'_, '_>,
        state: &AdmmState,
        workspace: &mut AdmmWorkspace,
    ) {
        match self {
            Self::Initialize => part.initialize(state),
            &Self::Prox { keeps_velocities } => {
                ContactKernel::Prox { keeps_velocities }.run(part, state);
            }
            &Self::Respond { starts_step, kind, keeps_velocities } => {
                part.respond(state, starts_step, kind, keeps_velocities, workspace);
            }
            Self::Extrapolate(update) => part.extrapolate(state, update, workspace),
            Self::EvalSplitting => ContactKernel::EvalSplitting.run(part, state),
            Self::EvalVelocities => part.eval_velocities(state, workspace),
            Self::EvalResidual => ContactKernel::EvalResidual.run(part, state),
            &Self::DescentGradient { evaluates_residual, slot } => {
                let increments = &mut workspace.increments;
                ContactKernel::DescentGradient { evaluates_residual, increments }.run(part, state);
                part.products = part.descent_history.record(&workspace.increments, slot);
            }
            Self::DescentUpdate(update) => {
                ContactKernel::DescentUpdate(update, &mut workspace.mixed).run(part, state);
            }
            Self::ReturnImpulses => part.return_impulses(),
        }
    }
}

/// Evaluates how far the velocities that have been evaluated are from the law.
pub(super) fn eval_residual<'a, 'b, A>(
    leader: &Leader<'_, '_, AdmmPart<'a, 'b>, Phase, AdmmWorkspace, A>,
) -> Report
where
    A: Fn(&Phase, &mut AdmmPart<'a, 'b>, &mut AdmmWorkspace) + Sync,
{
    leader.run(Phase::EvalResidual);
    residual_of_parts(leader)
}

/// Report on what all parts have evaluated, summed in their order.
pub(super) fn residual_of_parts<'a, 'b, A>(
    leader: &Leader<'_, '_, AdmmPart<'a, 'b>, Phase, AdmmWorkspace, A>,
) -> Report
where
    A: Fn(&Phase, &mut AdmmPart<'a, 'b>, &mut AdmmWorkspace) + Sync,
{
    let mut parts = Vec::new();
    leader.for_each(|part| parts.push(part.sums));
    ResidualSums::sum(&parts).report()
}
