//! The last digits: descent along the gradient, back into the cones, accelerated.
//!
//! ```text
//! r <- the impulses of the cones nearest to r - D (u(r) + de Saxcé's term along the normal)
//! ```
//!
//! where `u(r)` are the velocities that the impulses really cause (Tasora and Anitescu 2011 descend so
//! without acceleration). What many impulses do together, such as to shift a fibre as a whole, shows
//! most in `u`: splitting finds it last, descent first. Near the answer, and where things rest from the
//! start, it takes a tenth of the iterations; far from it, it creeps. `D` is a mass for each contact, about the
//! largest with which plain descent does not diverge.

use super::alone::Act;
use super::anderson::{Anderson, Onward, Place, Products};
use super::crew::Lead;
use super::part::{Common, Order, Part, Room, together};
use crate::{Report, Tolerance};

/// Steps that the acceleration remembers.
const MEMORY: usize = 5;

/// When descent is tried, and for how long.
pub(super) struct DescentPlan {
    /// From which error on, in tolerances.
    pub(super) near: f64,
    /// Iterations. Few contacts are then right to many more digits than asked for, as who starts from the
    /// answer of the step before wishes: small errors would shake what rests.
    pub(super) least: usize,
    pub(super) most: usize,
    /// By what factor the error may be above the course that leads to the end with the last of them.
    pub(super) off_course: f64,
}

/// Steps of the method, for all parts.
pub(super) enum Step {
    /// Finds where the gradient leads, and what the acceleration needs of it; also how far the velocities
    /// that have been told are from the law if one `judges`.
    Descend { judges: bool, place: Option<Place> },
    /// Takes the step, back into the cones.
    Onward(Onward),
}

/// Descends from impulses whose velocities have been told and leave an `error`, in tolerances. The report
/// once all are kept; `None` where that is far, or will not be in so many iterations, which are added.
pub(super) fn descend<'a, 'b, A>(
    lead: &Lead<'_, '_, Part<'a, 'b>, Order, Room, A>,
    tolerance: &Tolerance,
    error: f64,
    attempt: &DescentPlan,
    iterations: &mut usize,
) -> Option<Report>
where
    A: Fn(&Order, &mut Part<'a, 'b>, &mut Room) + Sync,
{
    if error > attempt.near {
        return None;
    }
    // Splitting has the last iteration.
    let most = tolerance.iterations.saturating_sub(*iterations + 1).min(attempt.most);
    let mut anderson = Anderson::new(MEMORY, 1);
    for done in 0..=most {
        // Velocities are judged in the pass that goes on from them.
        let judges = done > 0;
        lead.order(Order::Descent(Step::Descend { judges, place: anderson.place() }));
        if judges {
            let found = together(lead);
            let left = tolerance.error(&found);
            if left <= 1.0 && done >= attempt.least {
                return Some(found);
            }
            let course = error.max(1.0).powf(1.0 - done as f64 / attempt.most as f64);
            if left > attempt.off_course * course {
                return None;
            }
        }
        if done < most {
            *iterations += 1;
            let mut products = Products::default();
            lead.each(|part| products.add(&part.products));
            lead.order(Order::Descent(Step::Onward(anderson.onward(&products))));
            lead.order(Order::Tell);
        }
    }
    None
}

impl Part<'_, '_> {
    pub(super) fn descent(&mut self, common: &Common, step: &Step, room: &mut Room) {
        match step {
            Step::Descend { judges, place } => {
                let judges = *judges;
                self.alone(common, Act::Descend { judges, ways: &mut room.ways });
                self.products = self.descents.look(&room.ways, *place);
            }
            Step::Onward(onward) => self.alone(common, Act::Step(onward, &mut room.mixed)),
        }
    }
}
