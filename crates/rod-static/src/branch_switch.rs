//! Branches that leave another one at a bifurcation.

use crate::StaticError;
use crate::branch::{
    Branch, BranchEnd, BranchPoint, Followed, ParameterSweep, SHORTEST_BRANCH_STEP, WalkGoal,
};
use crate::branch_direction::Direction;
use crate::equilibrium::Equilibrium;
use crate::mode::{LimitKind, LimitPoint};
use crate::shooting::Effort;

impl ParameterSweep<'_> {
    /// The branch of [`ParameterSweep::follow`] up to a bifurcation, of those that it meets the one
    /// of index `bifurcation`, and from there the other branch that crosses it, to the side of the
    /// bifurcation's mode or `against` it: other shapes, or mirrored ones.
    ///
    /// The first step is taken along the mode, at a parameter that is found (Keller 1977); then
    /// the branch is followed as any other.
    ///
    /// # Errors
    /// As [`ParameterSweep::follow`], [`StaticError::NoBifurcation`] if so many are not met, and
    /// [`StaticError::NotFound`] if no branch is found there.
    pub fn follow_other(
        &self,
        start: &Equilibrium,
        bifurcation: usize,
        against: bool,
    ) -> Result<Branch, StaticError> {
        let mut branch = self.walk(start, WalkGoal::Bifurcation(bifurcation))?;
        if branch.ended != BranchEnd::Met {
            let met = branch.limits.iter().filter(|one| one.kind == LimitKind::Bifurcation).count();
            return Err(StaticError::NoBifurcation { asked: bifurcation, met });
        }
        let limit = branch.limits.last().ok_or(StaticError::NotFound)?;
        let (before, here) = self.beside(limit, against).ok_or(StaticError::NotFound)?;
        let equilibrium = here.judged().ok_or(StaticError::NotFound)?;
        branch.switched = Some(branch.points.len());
        branch.points.push(BranchPoint { parameter: here.parameter, equilibrium });
        Ok(self.march(branch, before, here, WalkGoal::End))
    }

    /// The bifurcation, and a point of the other branch a step away along its mode.
    fn beside(&self, limit: &LimitPoint, against: bool) -> Option<(Followed, Followed)> {
        let equilibrium = limit.mode.equilibrium();
        let at = Followed {
            parameter: limit.parameter,
            problem: (self.problem)(limit.parameter).ok()?,
            elements: equilibrium.elements.clone(),
            nodes: equilibrium.nodes.clone(),
        };
        let way = Direction { nodes: limit.mode.variations.clone(), parameter: 0.0 };
        let functional = way.functional(self.range());
        let side = if against { -1.0 } else { 1.0 };
        let unit = side / functional.product(&way).sqrt();
        let mut step = 1.0 / self.steps as f64;
        while step > SHORTEST_BRANCH_STEP {
            let mut predicted = at.clone();
            for (node, change) in predicted.nodes.iter_mut().zip(&way.nodes) {
                node.correct(&(change * (unit * step)));
            }
            if let Some(found) = self.across(predicted, &functional, &Effort::new()) {
                return Some((at, found));
            }
            step *= 0.5;
        }
        None
    }
}
