//! The last digits: descent along the gradient, back into the cones, accelerated.
//!
//! ```text
//! r <- the impulses of the cones nearest to r - D (u(r) + de Saxcé's term along the normal)
//! ```
//!
//! where `u(r)` are the velocities that the impulses really cause (Tasora and Anitescu 2011 descend
//! so without acceleration). What many impulses do together, such as to shift a fibre as a whole,
//! shows most in `u`: splitting finds it last, descent first. Near the answer, and where things
//! rest from the start, it takes a tenth of the iterations; far from it, it creeps. `D` is a mass
//! for each contact, about the largest with which plain descent does not diverge.

use super::admm_part::{AdmmPart, AdmmWorkspace};
use super::anderson::{Anderson, ResidualProducts};
use super::phase::{Phase, residual_of_parts};
use super::phase_pool::Leader;
use crate::{Report, Tolerance};

/// Steps that the acceleration of the descent remembers.
const DESCENT_MEMORY: usize = 5;

/// When descent is tried, and for how long.
pub(super) struct DescentPlan {
    /// Largest error with which it is tried, in tolerances.
    pub(super) largest_error: f64,
    /// Fewest iterations. Few contacts are then right to many more digits than asked for, as who
    /// starts from the answer of the step before wishes: small errors would shake what rests.
    pub(super) min_iterations: usize,
    /// Most iterations.
    pub(super) max_iterations: usize,
    /// Factor by which the error may be above the geometric course that leads to the tolerance with
    /// the last iteration.
    pub(super) off_course: f64,
}

/// Descends from impulses whose velocities have been evaluated and leave an `error`, in tolerances.
/// The report once all tolerances are kept; `None` where that is far, or will not be in the
/// iterations of the plan. Iterations are added to `iterations`.
pub(super) fn descend<'a, 'b, A>(
    leader: &Leader<'_, '_, AdmmPart<'a, 'b>, Phase, AdmmWorkspace, A>,
    tolerance: &Tolerance,
    error: f64,
    plan: &DescentPlan,
    iterations: &mut usize,
) -> Option<Report>
where
    A: Fn(&Phase, &mut AdmmPart<'a, 'b>, &mut AdmmWorkspace) + Sync,
{
    if error > plan.largest_error {
        return None;
    }
    // Splitting has the last iteration.
    let left_iterations = tolerance.iterations.saturating_sub(*iterations + 1);
    let most = left_iterations.min(plan.max_iterations);
    let mut anderson = Anderson::new(DESCENT_MEMORY, 1);
    for done in 0..=most {
        // The gradient step; velocities are judged in the pass that goes on from them.
        let evaluates_residual = done > 0;
        let slot = anderson.next_slot();
        leader.run(Phase::DescentGradient { evaluates_residual, slot });
        if evaluates_residual {
            let found = residual_of_parts(leader);
            let left = tolerance.error(&found);
            if left <= 1.0 && done >= plan.min_iterations {
                return Some(found);
            }
            let course = error.max(1.0).powf(1.0 - done as f64 / plan.max_iterations as f64);
            if left > plan.off_course * course {
                return None;
            }
        }
        if done < most {
            *iterations += 1;
            // Anderson's acceleration over all parts, then the velocities of the new impulses.
            let mut products = ResidualProducts::default();
            leader.for_each(|part| products.add(&part.products));
            leader.run(Phase::DescentUpdate(anderson.update(&products)));
            leader.run(Phase::EvalVelocities);
        }
    }
    None
}
