//! Continuation of an equilibrium in the loads and in the end condition, and its refinement.

use crate::equilibrium::Equilibrium;
use crate::goal::Goal;
use crate::mesh::{MeshElement, Scaled};
use crate::shooting::{Effort, RootHold, Shooting, newton};
use crate::stability::index;
use crate::step::ShootingNode;

/// First step of a continuation, as a fraction of the path.
const FIRST: f64 = 0.25;
/// Shortest step of a continuation, as a fraction of the part of the path behind it.
const SHORTEST_LOAD_STEP: f64 = 1e-3;
/// Least value of that part in the comparison with the shortest step: loads grow by their
/// logarithm.
const SMALLEST: f64 = 1e-6;
/// Distance from the goal that is tried in one step, in lengths, radians and stiffness over length.
const NEAR_SOLUTION: f64 = 0.1;
/// Largest number of times that the elements of a solution are split.
const REFINEMENTS: usize = 4;

/// Start of a continuation: a shape, the fraction of the loads that acts on it, and whole turns of
/// the end about its tangent along the path.
pub(crate) struct ContinuationStart {
    pub(crate) nodes: Vec<ShootingNode>,
    pub(crate) factor: f64,
    pub(crate) turns: f64,
}

/// A rod and a condition on its end, to which equilibria are continued.
pub(crate) struct Continuation<'a> {
    pub(crate) rod: &'a Scaled,
    pub(crate) root: RootHold,
    pub(crate) goal: &'a Goal,
    pub(crate) effort: &'a Effort,
}

impl Continuation<'_> {
    /// The equations with the condition `goal` on the end and the fraction `factor` of the loads.
    fn shooting<'b>(&'b self, goal: &'b Goal, factor: f64) -> Shooting<'b> {
        Shooting { rod: self.rod, root: self.root, goal, factor }
    }

    /// Continuation from `start` in the loads and in the end condition together, and refinement.
    pub(crate) fn follow(
        &self,
        elements: &[MeshElement],
        start: &ContinuationStart,
    ) -> Option<Equilibrium> {
        let nodes = self.continued(elements, start, 1.0)?;
        self.finish(elements.to_vec(), nodes, 1.0)
    }

    /// Continuation from `start` to the end condition and the fraction `loads` of the loads.
    pub(crate) fn continued(
        &self,
        elements: &[MeshElement],
        start: &ContinuationStart,
        loads: f64,
    ) -> Option<Vec<ShootingNode>> {
        let tip = start.nodes.last()?;
        let mut nodes = start.nodes.clone();
        let near = start.factor >= loads && self.goal.missed(tip)?.0.norm() < NEAR_SOLUTION;
        let (mut at, mut step) = (0.0_f64, if near { 1.0 } else { FIRST });
        // The step doubles after a success and halves after a failure.
        while at < 1.0 {
            let next = (at + step).min(1.0);
            let goal = self.goal.on_the_way(tip, start.turns, next)?;
            let factor = start.factor + (loads - start.factor) * next;
            let mut trial = nodes.clone();
            if newton(&self.shooting(&goal, factor), elements, &mut trial, self.effort).is_some() {
                (nodes, at, step) = (trial, next, 2.0 * step);
            } else {
                step *= 0.5;
                if step < SHORTEST_LOAD_STEP * at.max(SMALLEST) {
                    return None;
                }
            }
        }
        Some(nodes)
    }

    /// Refines the elements until the solution is resolved, and computes its stability and
    /// energies.
    pub(crate) fn finish(
        &self,
        mut elements: Vec<MeshElement>,
        mut nodes: Vec<ShootingNode>,
        factor: f64,
    ) -> Option<Equilibrium> {
        let of = self.shooting(self.goal, factor);
        newton(&of, &elements, &mut nodes, self.effort)?;
        for _ in 0..REFINEMENTS {
            let Some(finer) = self.rod.refined(&elements, &nodes, factor) else { break };
            (elements, nodes) = finer;
            newton(&of, &elements, &mut nodes, self.effort)?;
        }
        self.judged(elements, nodes, factor)
    }

    /// The equilibrium of nodes that are in balance, with its stability and energies.
    pub(crate) fn judged(
        &self,
        elements: Vec<MeshElement>,
        nodes: Vec<ShootingNode>,
        factor: f64,
    ) -> Option<Equilibrium> {
        // Stability by conjugate points.
        let conjugate_points = index(&self.shooting(self.goal, factor), &elements, &nodes)?;
        let found = self.resting(elements, nodes, factor)?;
        Some(Equilibrium { conjugate_points, ..found })
    }

    /// The equilibrium of nodes that are in balance, with its elastic energy and the work of its
    /// loads; its conjugate points are not counted.
    pub(crate) fn resting(
        &self,
        elements: Vec<MeshElement>,
        nodes: Vec<ShootingNode>,
        factor: f64,
    ) -> Option<Equilibrium> {
        let (mut elastic, mut work) = (0.0, 0.0);
        for (element, node) in elements.iter().zip(&nodes) {
            let properties = self.rod.properties(element, factor);
            let reached = node.step(element.from, element.to, properties);
            elastic += reached.elastic;
            work += reached.work + factor * element.end_load.dot(&reached.node.r);
        }
        work += self.goal.force_on_end().dot(&nodes.last()?.r);
        let (rod, conjugate_points) = (self.rod.clone(), 0);
        Some(Equilibrium { rod, elements, nodes, factor, elastic, work, conjugate_points })
    }
}
