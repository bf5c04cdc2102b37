//! Branches of equilibria: how an equilibrium changes with a parameter, past folds.

use crate::StaticError;
use crate::branch_direction::{Direction, direction};
use crate::equilibrium::Equilibrium;
use crate::error::finite;
use crate::mesh::MeshElement;
use crate::mode::{LimitKind, LimitPoint};
use crate::problem::Problem;
use crate::shooting::{Effort, ParameterSlopes, Shooting, corrected, iterate, newton};
use crate::step::ShootingNode;
use nalgebra::SVector;

/// Change of the parameter for differences, in parts of the range.
const DIFFERENCE: f64 = 1e-5;
/// Shortest step along a branch, in parts of the longest.
pub(crate) const SHORTEST_BRANCH_STEP: f64 = 1e-5;
/// Growth of the step after a success.
const LONGER: f64 = 1.5;
/// Least cosine between two steps that follow each other.
const STRAIGHT: f64 = 0.7;
/// The cosine above which steps of the parameter are limited, not their length.
const VERY_STRAIGHT: f64 = 0.999;
/// Largest rotation of a node on a step, rad: beyond half a turn it would count as its opposite.
const MOST_TURN: f64 = 2.0;
/// Parts of a step in which the first direction is looked for: a ring gives way to twist fast.
const PROBES: [f64; 6] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-2, 1e-1];
/// Most steps along a branch, in the number of steps that were asked for.
const MOST_BRANCH_STEPS: usize = 20;
/// Largest number of times that the elements of a point are split.
const SPLITS: usize = 4;

/// A parameter of a problem, and the range in which equilibria are followed.
pub struct ParameterSweep<'a> {
    /// The problem at a value of the parameter. All have the same number of pieces.
    pub problem: &'a dyn Fn(f64) -> Result<Problem, StaticError>,
    /// Value of the parameter at the start.
    pub from: f64,
    /// Value of the parameter at which the branch ends.
    pub to: f64,
    /// Number of steps, at least, in which it goes from one to the other.
    pub steps: usize,
}

/// A branch of equilibria.
#[derive(Debug, Clone)]
pub struct Branch {
    /// Points of the branch, in order.
    pub points: Vec<BranchPoint>,
    /// Points where an equilibrium gains or loses directions of falling energy, in order.
    pub limits: Vec<LimitPoint>,
    /// Why the branch ends.
    pub ended: BranchEnd,
    /// Index of the first point of another branch, where one was left for that at the limit before
    /// it.
    pub switched: Option<usize>,
}

/// An equilibrium and the value of the parameter.
#[derive(Debug, Clone)]
pub struct BranchPoint {
    /// Value of the parameter.
    pub parameter: f64,
    /// The equilibrium.
    pub equilibrium: Equilibrium,
}

/// Why a branch ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BranchEnd {
    /// It has reached the end of the range.
    Reached,
    /// Past a fold it has come back to the start of the range.
    Returned,
    /// It has lost its stability, where that was asked for.
    Lost,
    /// It was followed for many times the steps that were asked for.
    Long,
    /// It has met the bifurcation at which it was to be left.
    Met,
    /// Newton's method did not converge however short the step.
    Stuck,
}

/// Up to where a branch is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WalkGoal {
    /// The end of the range.
    End,
    /// Where it loses its stability.
    Unstable,
    /// A bifurcation, by its index among those that are met.
    Bifurcation(usize),
}

/// A step along a branch.
struct BranchStep {
    next: Followed,
    /// The end of the branch, if the next point is that.
    end: Option<BranchEnd>,
    /// Length of the step, in parts of the range.
    length: f64,
    /// Whether the branch hardly turned.
    is_straight: bool,
}

/// A point of a branch with its nodes, on a mesh of its own.
#[derive(Clone)]
pub(crate) struct Followed {
    pub(crate) parameter: f64,
    pub(crate) problem: Problem,
    pub(crate) elements: Vec<MeshElement>,
    pub(crate) nodes: Vec<ShootingNode>,
}

impl Followed {
    pub(crate) fn shooting(&self) -> Shooting<'_> {
        self.problem.shooting()
    }

    pub(crate) fn judged(&self) -> Option<Equilibrium> {
        let (elements, nodes) = (self.elements.clone(), self.nodes.clone());
        self.problem.continuation(&Effort::new()).judged(elements, nodes, 1.0)
    }

    /// The equilibrium where its conjugate points cannot be counted: they are left at none.
    pub(crate) fn resting(&self) -> Option<Equilibrium> {
        let (elements, nodes) = (self.elements.clone(), self.nodes.clone());
        self.problem.continuation(&Effort::new()).resting(elements, nodes, 1.0)
    }

    /// The same point with each of its elements in two.
    pub(crate) fn halved(&self) -> Self {
        let (elements, nodes) = self.problem.rod.halved(&self.elements, &self.nodes, 1.0);
        Self { elements, nodes, parameter: self.parameter, problem: self.problem.clone() }
    }

    /// The nodes of this point on the mesh of another one.
    fn on_mesh_of(&self, other: &Self) -> Option<Vec<ShootingNode>> {
        let rod = &self.problem.rod;
        let elements = rod.elements_like(&other.elements, &other.problem.rod)?;
        let at = |s: f64| rod.node_at(&self.elements, &self.nodes, 1.0, s);
        Some([self.nodes[0]].into_iter().chain(elements.iter().map(|e| at(e.to))).collect())
    }
}

impl ParameterSweep<'_> {
    /// The branch of equilibria from `start`, an equilibrium of the problem at the start of the
    /// range or near one, by continuation in the arc length of the branch (Riks 1972, Keller 1977):
    /// past folds, in steps that follow the curvature of the branch.
    ///
    /// Where the stability changes, the point is found to the rounding of the equations. At a
    /// bifurcation the branch goes straight on; see [`ParameterSweep::follow_other`]. Cost: about
    /// five Newton steps for each point.
    ///
    /// # Errors
    /// [`StaticError::NoSteps`], numbers that are not finite, an empty range, errors of the problem
    /// at the start, and [`StaticError::NotFound`] if Newton's method does not lead from `start` to
    /// an equilibrium.
    pub fn follow(&self, start: &Equilibrium) -> Result<Branch, StaticError> {
        self.walk(start, WalkGoal::End)
    }

    /// The branch of [`ParameterSweep::follow`] up to where it loses its stability: its last limit,
    /// if it ends by [`BranchEnd::Lost`].
    ///
    /// # Errors
    /// As [`ParameterSweep::follow`], and [`StaticError::Unstable`] for a start that is not stable.
    pub fn until_unstable(&self, start: &Equilibrium) -> Result<Branch, StaticError> {
        self.walk(start, WalkGoal::Unstable)
    }

    pub(crate) fn walk(&self, start: &Equilibrium, until: WalkGoal) -> Result<Branch, StaticError> {
        if self.steps == 0 {
            return Err(StaticError::NoSteps);
        }
        finite("the range of a parameter", &[self.from, self.to])?;
        if self.from == self.to {
            return Err(StaticError::NoRange { value: self.from });
        }
        let problem = (self.problem)(self.from)?;
        let elements = problem.rod.elements_like(&start.elements, &start.rod);
        let elements = elements.ok_or(StaticError::NotFound)?;
        let first =
            Followed { parameter: self.from, problem, elements, nodes: start.nodes.clone() };
        let first = self.fixed(first, self.from).ok_or(StaticError::NotFound)?;
        let equilibrium = first.judged().ok_or(StaticError::NotFound)?;
        if until == WalkGoal::Unstable && !equilibrium.is_stable() {
            return Err(StaticError::Unstable { ways: equilibrium.conjugate_points() });
        }
        let points = vec![BranchPoint { parameter: self.from, equilibrium }];
        let branch = Branch { points, limits: Vec::new(), ended: BranchEnd::Long, switched: None };
        let step = self.range() / self.steps as f64;
        let probe = |part: &f64| self.fixed(first.clone(), self.from + part * step);
        let probe = PROBES.iter().find_map(probe).ok_or(StaticError::NotFound)?;
        Ok(self.march(branch, first, probe, until))
    }

    /// The branch with what follows on its last point, `here` or near it on the way from `before`.
    pub(crate) fn march(
        &self,
        branch: Branch,
        mut before: Followed,
        mut here: Followed,
        until: WalkGoal,
    ) -> Branch {
        let Branch { mut points, mut limits, switched, .. } = branch;
        let (most, longest) =
            (points.len() + MOST_BRANCH_STEPS * self.steps, 1.0 / self.steps as f64);
        let (mut step, mut ended) = (longest, BranchEnd::Long);
        while points.len() <= most {
            let next = self.next(&before, &here, step);
            let judged = next.and_then(|step| Some((step.next.judged()?, step)));
            let Some((equilibrium, taken)) = judged else {
                step *= 0.5;
                if step < SHORTEST_BRANCH_STEP * longest {
                    ended = BranchEnd::Stuck;
                    break;
                }
                continue;
            };
            let BranchStep { next, end, length, is_straight } = taken;
            let counts = [&points[points.len() - 1].equilibrium, &equilibrium];
            let counts = counts.map(Equilibrium::conjugate_points);
            if counts[0] != counts[1] {
                limits.extend(self.limits(&here, &next, counts));
                let is_bifurcation =
                    |one: &(usize, &LimitPoint)| one.1.kind == LimitKind::Bifurcation;
                if let WalkGoal::Bifurcation(asked) = until
                    && let Some((met, _)) =
                        limits.iter().enumerate().filter(is_bifurcation).nth(asked)
                {
                    limits.truncate(met + 1);
                    ended = BranchEnd::Met;
                    break;
                }
            }
            points.push(BranchPoint { parameter: next.parameter, equilibrium });
            if until == WalkGoal::Unstable && counts[1] > 0 {
                ended = BranchEnd::Lost;
                break;
            }
            if let Some(end) = end {
                ended = end;
                break;
            }
            before = std::mem::replace(&mut here, next);
            step = LONGER * length;
            if !is_straight {
                step = step.min(longest);
            }
        }
        Branch { points, limits, ended, switched }
    }

    pub(crate) fn range(&self) -> f64 {
        self.to - self.from
    }

    /// The step of at most the length `step` to the next point.
    fn next(&self, before: &Followed, here: &Followed, step: f64) -> Option<BranchStep> {
        let part = |parameter: f64| (parameter - self.from) / self.range();
        let way =
            direction(&before.on_mesh_of(here)?, before.parameter, &here.nodes, here.parameter);
        let functional = way.functional(self.range());
        let size = functional.product(&way).sqrt();
        let turn = way.nodes.iter().map(|v| v.fixed_rows::<3>(3).norm()).fold(0.0, f64::max);
        let longest = (self.range() / (self.steps as f64 * way.parameter)).abs();
        let tau = (step / size).min(longest).min(MOST_TURN / turn);
        let ahead = part(here.parameter + tau * way.parameter);
        // To the ends of the range exactly.
        let end = if ahead >= 1.0 {
            Some((self.to, BranchEnd::Reached))
        } else if ahead <= 0.0 {
            Some((self.from, BranchEnd::Returned))
        } else {
            None
        };
        let next = match end {
            Some((bound, _)) => {
                let tau = (bound - here.parameter) / way.parameter;
                let mut guess = here.clone();
                for (node, change) in guess.nodes.iter_mut().zip(&way.nodes) {
                    node.correct(&(change * tau));
                }
                self.fixed(guess, bound)?
            }
            None => self.between(before, here, tau)?,
        };
        // No jump to another branch.
        let on = direction(&here.nodes, here.parameter, &next.on_mesh_of(here)?, next.parameter);
        let along = functional.product(&on);
        let sizes = [&way, &on].map(|d| d.functional(self.range()).product(d).sqrt());
        let inside = end.is_some() || (0.0..=1.0).contains(&part(next.parameter));
        let straight = |least: f64| along >= least * sizes[0] * sizes[1];
        let (end, is_straight) = (end.map(|(_, end)| end), straight(VERY_STRAIGHT));
        let step = BranchStep { next, end, length: tau * size, is_straight };
        (straight(STRAIGHT) && inside).then_some(step)
    }

    /// The equilibrium at a value of the parameter near `guess`.
    pub(crate) fn fixed(&self, guess: Followed, parameter: f64) -> Option<Followed> {
        let problem = (self.problem)(parameter).ok()?;
        let elements = problem.rod.elements_like(&guess.elements, &guess.problem.rod)?;
        let mut found = Followed { parameter, problem, elements, nodes: guess.nodes };
        let effort = Effort::new();
        for _ in 0..=SPLITS {
            let mut nodes = found.nodes.clone();
            newton(&found.shooting(), &found.elements, &mut nodes, &effort)?;
            found.nodes = nodes;
            let finer = found.problem.rod.refined(&found.elements, &found.nodes, 1.0);
            let Some(finer) = finer else { break };
            (found.elements, found.nodes) = finer;
        }
        Some(found)
    }

    /// The equilibrium at the part `tau` of the way from `a` to `b`, counted from `b`, across that
    /// way.
    pub(crate) fn between(&self, a: &Followed, b: &Followed, tau: f64) -> Option<Followed> {
        let mut mesh = b.clone();
        let effort = Effort::new();
        for _ in 0..=SPLITS {
            let nodes = [a.on_mesh_of(&mesh)?, b.on_mesh_of(&mesh)?];
            let way = direction(&nodes[0], a.parameter, &nodes[1], b.parameter);
            let [_, nodes] = nodes;
            let mut predicted = Followed { nodes, ..mesh };
            predicted.parameter = b.parameter + tau * way.parameter;
            for (node, change) in predicted.nodes.iter_mut().zip(&way.nodes) {
                node.correct(&(change * tau));
            }
            mesh = self.across(predicted, &way.functional(self.range()), &effort)?;
            let finer = mesh.problem.rod.refined(&mesh.elements, &mesh.nodes, 1.0);
            let Some(finer) = finer else { break };
            (mesh.elements, mesh.nodes) = finer;
        }
        Some(mesh)
    }

    /// The equilibrium near `predicted`, from which it differs across a direction alone.
    pub(crate) fn across(
        &self,
        predicted: Followed,
        functional: &Direction,
        effort: &Effort,
    ) -> Option<Followed> {
        let mut found = predicted.clone();
        iterate(3 * found.elements.len(), effort, || {
            let problem = (self.problem)(found.parameter).ok()?;
            found.elements = problem.rod.elements_like(&found.elements, &found.problem.rod)?;
            found.problem = problem;
            let slopes = self.slopes(&found)?;
            let off =
                direction(&predicted.nodes, predicted.parameter, &found.nodes, found.parameter);
            let linear =
                found.shooting().eliminated(&found.elements, &found.nodes, Some(&slopes))?;
            let (corrections, change) = linear.corrections_along(
                &functional.nodes,
                functional.parameter,
                -functional.product(&off),
            )?;
            found.parameter += change;
            let size = corrected(&mut found.nodes, &corrections);
            Some(size.max((change / self.range()).abs()))
        })?;
        // The last change of the parameter is below what counts.
        let problem = (self.problem)(found.parameter).ok()?;
        found.elements = problem.rod.elements_like(&found.elements, &found.problem.rod)?;
        found.problem = problem;
        Some(found)
    }

    /// Derivatives of the equations by the parameter, by differences.
    pub(crate) fn slopes(&self, at: &Followed) -> Option<ParameterSlopes> {
        let h = DIFFERENCE * self.range().abs();
        // At the edge of what is possible, to one side.
        let beside = |side: f64| match (self.problem)(at.parameter + side) {
            Ok(problem) => Some((problem, side)),
            Err(_) => Some(((self.problem)(at.parameter).ok()?, 0.0)),
        };
        let [(low, a), (high, b)] = [beside(-h)?, beside(h)?];
        let per = if b > a { 1.0 / (b - a) } else { return None };
        let [before, behind] =
            [&low, &high].map(|p| p.rod.elements_like(&at.elements, &at.problem.rod));
        let (before, behind) = (before?, behind?);
        let last = at.nodes.last()?;
        let mut ends = Vec::with_capacity(at.elements.len());
        for (node, (one, other)) in at.nodes.iter().zip(before.iter().zip(&behind)) {
            let end = |problem: &Problem, element: &MeshElement| {
                let properties = problem.rod.properties(element, 1.0);
                let end = node.step(element.from, element.to, properties).node;
                ShootingNode { n: end.n - element.end_load, ..end }
            };
            ends.push(end(&high, other).minus(&end(&low, one)) * per);
        }
        let root = (high.root.missed(&at.nodes[0]) - low.root.missed(&at.nodes[0])) * per;
        let goal: SVector<f64, 6> = (high.goal.missed(last)?.0 - low.goal.missed(last)?.0) * per;
        Some(ParameterSlopes { root, ends, goal })
    }
}
