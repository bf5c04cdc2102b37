use crate::StaticError;
use crate::chain::{Chain, TipHold};
use crate::equilibrium::Equilibrium;
use crate::error::finite;
use crate::goal::Goal;
use crate::mesh::{MeshElement, Scaled};
use crate::rod::{EndCondition, Piece};
use crate::shooting::{Effort, newton};
use crate::stability::index;
use crate::state::State;
use crate::step::ShootingNode;
use crate::target::Target;
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use std::f64::consts::TAU;

/// First step of a continuation, in parts of the way; shortest one, in parts of what is behind, and
/// the least that counts for that: loads grow by their logarithm.
const FIRST: f64 = 0.25;
const SHORTEST_LOAD_STEP: f64 = 1e-3;
const SMALLEST: f64 = 1e-6;
/// A way short enough to be tried in one step, in lengths, radians and stiffness by length.
const NEAR_SOLUTION: f64 = 0.1;
/// How often the elements are split before the solution counts as not resolved.
const REFINEMENTS: usize = 4;
/// Moments that bend the shapes to start from, in units of stiffness by length.
const BENDING: [f64; 4] = [1.5, 3.0, 5.0, 7.0];
/// Directions in which they bend.
const DIRECTIONS: u32 = 8;
/// Stiffness of the spring that holds an end, in units of the rod's, and how often its place is
/// corrected: each time what it stretches falls by about that.
const STIFF: f64 = 100.0;
const HELD: usize = 4;
/// What a search for the minimum costs, in steps along its elements.
const RELAX: usize = 10;
/// Torques that twist them as well.
const TWISTING: [f64; 3] = [0.0, 2.0, -2.0];

/// A rod clamped at its root, loaded along its length, with a condition on its far end.
///
/// Inextensible and unshearable; dead loads; stiffnesses and natural curvature may vary along the
/// rod and jump between pieces. The six unknowns are force and moment at the clamp.
#[derive(Debug, Clone)]
pub struct Problem {
    rod: Scaled,
    clamp: (Vector3<f64>, UnitQuaternion<f64>),
    goal: Goal,
    /// Those of every way to a solution.
    elements: Vec<MeshElement>,
}

/// Where a continuation begins: a shape, the part of the loads on it, and whole turns of the end
/// about its tangent on the way.
struct ContinuationStart {
    nodes: Vec<ShootingNode>,
    factor: f64,
    turns: f64,
}

impl Problem {
    /// The rod made of `pieces`, in order from the clamp, whose pose is `clamp`: its z axis is the
    /// tangent.
    ///
    /// # Errors
    /// No pieces, lengths or stiffnesses that are not positive, numbers that are not finite, an end
    /// farther from the clamp than the rod is long, and [`StaticError::TooFine`].
    pub fn new(
        clamp: &Isometry3<f64>,
        pieces: Vec<Piece>,
        end: EndCondition,
    ) -> Result<Self, StaticError> {
        let rod = Scaled::new(pieces)?;
        finite("the pose of the clamp", clamp.translation.vector.as_slice())?;
        finite("the pose of the clamp", clamp.rotation.coords.as_slice())?;
        end.validate()?;
        if let Some(position) = end.position() {
            let distance = (position.coords - clamp.translation.vector).norm();
            if distance > rod.length {
                return Err(StaticError::OutOfReach { distance, length: rod.length });
            }
        }
        let goal = Goal::of(&end, &rod);
        let elements = rod.elements(match goal {
            Goal::Free { force, moment } => [force.norm(), moment.norm()],
            _ => [0.0; 2],
        })?;
        let clamp = (clamp.translation.vector / rod.length, clamp.rotation);
        Ok(Self { rod, clamp, goal, elements })
    }

    /// An equilibrium, stable if one is found. No random numbers.
    ///
    /// Where the end is free and no moment acts on it: from the natural shape down to a minimum of
    /// the energy. Else, and if that fails, by continuation from the natural shape without loads,
    /// but bent by the moment on the end, and from bent shapes, the nearest to the condition on the
    /// end first; from an unstable equilibrium the energy leads down.
    ///
    /// # Errors
    /// [`StaticError::NotFound`] if no start leads to an equilibrium.
    pub fn solve(&self) -> Result<Equilibrium, StaticError> {
        let effort = Effort::new();
        self.any(&effort).ok_or(StaticError::NotFound)
    }

    /// The equilibria that all starts lead to, also with up to `turns` whole turns of the end
    /// about its tangent to either side, and that of [`Problem::solve`], sorted by energy. Those
    /// that differ by a turn or a reflection of the whole are told once. There may be more.
    #[must_use]
    pub fn solutions(&self, turns: u16) -> Vec<Equilibrium> {
        let effort = Effort::new();
        let turns: Vec<f64> = (0..=turns)
            .flat_map(|k| if k == 0 { vec![0.0] } else { vec![f64::from(k), -f64::from(k)] })
            .collect();
        let mut found: Vec<Equilibrium> = self.any(&effort).into_iter().collect();
        for nodes in self.starts(&effort) {
            for &turns in &turns {
                let start = ContinuationStart { nodes: nodes.clone(), factor: 0.0, turns };
                if let Some(one) = self.follow(&self.elements, &start, &effort)
                    && !found.iter().any(|other| other.is_like(&one))
                {
                    found.push(one);
                }
            }
        }
        found.sort_by(|a, b| a.energy().total_cmp(&b.energy()));
        found
    }

    /// The equilibrium that continuation from `start` leads to: an equilibrium of the same pieces
    /// and clamp with another end, or one of [`Problem::bent`]. Loads grow on the way from the part
    /// of them that acts on `start`.
    ///
    /// # Errors
    /// [`StaticError::NotFound`] if the way there is blocked.
    pub fn solve_from(&self, start: &Equilibrium) -> Result<Equilibrium, StaticError> {
        let nodes = start.nodes.clone();
        let start_at = ContinuationStart { nodes, factor: start.factor, turns: 0.0 };
        self.follow(&start.elements, &start_at, &Effort::new()).ok_or(StaticError::NotFound)
    }

    /// The rod without its loads and its condition on the end, bent by the dead `moment` (N m,
    /// world frame) on the end: a shape to start from with [`Problem::solve_from`].
    ///
    /// # Errors
    /// [`StaticError::NotFound`] if it is too much to be resolved.
    pub fn bent(&self, moment: &Vector3<f64>) -> Result<Equilibrium, StaticError> {
        let moment = moment / self.rod.energy();
        let elements = self.rod.elements([0.0, moment.norm()])?;
        let nodes = self.rod.natural(&elements, self.clamp, moment);
        let goal = Goal::Free { force: Vector3::zeros(), moment };
        self.finish(elements, nodes, &goal, 0.0, &Effort::new()).ok_or(StaticError::NotFound)
    }

    /// The equilibrium near the states `guess` at ascending arc lengths, m, the first of them zero:
    /// Newton's method at once, also for an unstable one.
    ///
    /// # Errors
    /// [`StaticError::NotFound`] if Newton's method does not converge or the guess is empty.
    pub fn solve_near(&self, guess: &[(f64, State)]) -> Result<Equilibrium, StaticError> {
        let mut guess = guess.iter().map(|(s, state)| (s / self.rod.length, state)).peekable();
        let (_, first) = guess.next().ok_or(StaticError::NotFound)?;
        let elements = &self.elements;
        let (r, q) = self.clamp;
        let mut nodes = vec![ShootingNode { r, q, ..self.rod.scale(first) }];
        for element in elements {
            let (mut from, mut node) = (element.from, nodes[nodes.len() - 1]);
            while let Some((s, state)) = guess.next_if(|(s, _)| *s < element.to) {
                (from, node) = (s, self.rod.scale(state));
            }
            let properties = self.rod.properties(element, 1.0);
            let mut end = node.step(from, element.to, properties).node;
            end.n -= element.end_load;
            nodes.push(end);
        }
        // The guess says how fine the elements must be, before Newton's method leaves it.
        let finer = self.rod.refined(elements, &nodes, 1.0);
        let (elements, nodes) = finer.unwrap_or_else(|| (elements.clone(), nodes));
        let found = self.finish(elements, nodes, &self.goal, 1.0, &Effort::new());
        found.ok_or(StaticError::NotFound)
    }

    /// The equilibrium that [`Problem::solve`] tells.
    fn any(&self, effort: &Effort) -> Option<Equilibrium> {
        let mut unstable = None;
        for nodes in self.starts(effort) {
            match self.reach(&ContinuationStart { nodes, factor: 0.0, turns: 0.0 }, effort) {
                Some(found) if found.is_stable() => return Some(found),
                Some(found) => unstable = unstable.or(Some(found)),
                None => {}
            }
        }
        unstable
    }

    /// The equilibrium that `start` leads to, stable if one is found.
    fn reach(&self, start: &ContinuationStart, effort: &Effort) -> Option<Equilibrium> {
        let elements = &self.elements;
        let free = matches!(self.goal, Goal::Free { .. });
        let stable = |found: &Option<Equilibrium>| found.as_ref().is_some_and(|f| f.is_stable());
        if free {
            let found = self.descend(elements, &start.nodes, effort);
            if stable(&found) {
                return found;
            }
        }
        let found = self.follow(elements, start, effort);
        if stable(&found) {
            return found;
        }
        let (elements, nodes) = match &found {
            Some(saddle) => (&saddle.elements, saddle.nodes.clone()),
            // Where the loads block the way, they are put on at its end.
            None if free => (elements, start.nodes.clone()),
            None => (elements, self.continued(elements, start, 0.0, effort)?),
        };
        let down = self.descend(elements, &nodes, effort).filter(Equilibrium::is_stable);
        down.or_else(|| self.around(elements, &nodes, effort)).or(found)
    }

    /// The equilibrium that a push leads to, which is then taken away. Near a load that buckles it,
    /// the rod in segments may stand where the rod does not; pushed, both lean.
    fn around(
        &self,
        elements: &[MeshElement],
        nodes: &[ShootingNode],
        effort: &Effort,
    ) -> Option<Equilibrium> {
        let pushed = Self { goal: self.goal.pushed(), ..self.clone() };
        let start = ContinuationStart { nodes: nodes.to_vec(), factor: 1.0, turns: 0.0 };
        let nodes = match self.goal {
            Goal::Free { .. } => start.nodes,
            _ => pushed.continued(elements, &start, 1.0, effort)?,
        };
        let leaning = pushed.descend(elements, &nodes, effort)?;
        let start = ContinuationStart { nodes: leaning.nodes, factor: 1.0, turns: 0.0 };
        self.follow(&leaning.elements, &start, effort)
    }

    /// The equilibrium near the minimum of the energy that the rod in segments reaches from
    /// `nodes`, which meet the conditions on the end. `None` also for a moment on the end, which
    /// has no energy.
    fn descend(
        &self,
        elements: &[MeshElement],
        nodes: &[ShootingNode],
        effort: &Effort,
    ) -> Option<Equilibrium> {
        let rod = &self.rod;
        let (r, q) = self.clamp;
        let clamp = Isometry3::from_parts((r * rod.length).into(), q);
        let lengths: Vec<_> =
            elements.iter().map(|e| (e.piece, (e.to - e.from) * rod.length)).collect();
        let mut chain = Chain::cut(&clamp, rod.pieces(), &lengths).ok()?;
        let last = elements.len();
        let mut place = None;
        match self.goal {
            Goal::Free { moment, .. } if moment != Vector3::zeros() => return None,
            Goal::Free { force, .. } => chain.forces[last] += force * rod.force(),
            Goal::Position { position, .. } => place = Some(position),
            Goal::Tangent { position, .. } => {
                (chain.tip, place) = (TipHold::Aligned, Some(position));
            }
            Goal::Held { position, .. } => (chain.tip, place) = (TipHold::Held, Some(position)),
        }
        let mut shape = chain.shape(nodes.iter().map(|node| node.q).collect());
        let mut pull = nodes.last()?.n * rod.force();
        let stiffness = STIFF * chain.stiffness() + 10.0 * pull.norm() / rod.length;
        let mut rest = None;
        // A spring holds the end, at a place moved by what it stretches (Hestenes 1969).
        for _ in 0..if place.is_some() { HELD } else { 1 } {
            effort.spend(RELAX * last)?;
            if let Some(place) = place {
                let place = Point3::from(place * rod.length + pull / stiffness);
                chain.set_targets(&[Target::pulled(last, place, stiffness)]).ok()?;
            }
            let found = chain.relax(&shape).ok()?;
            (shape, pull) = (found.shape.clone(), found.pulls.first().copied().unwrap_or(pull));
            rest = Some(found);
        }
        let states = chain.states(&rest?);
        let mut nodes: Vec<ShootingNode> = states.iter().map(|state| rod.scale(state)).collect();
        nodes[last].n = match self.goal {
            Goal::Free { force, .. } => force,
            _ => pull / rod.force(),
        };
        for (i, element) in elements.iter().enumerate().rev() {
            let middle = 0.5 * (element.from + element.to);
            let load = rod.properties(element, 1.0)(middle).load * (element.to - element.from);
            nodes[i].n = nodes[i + 1].n + element.end_load + load;
        }
        self.finish(elements.to_vec(), nodes, &self.goal, 1.0, effort)
    }

    /// The shapes to start from: the natural one, bent by the moment on the end, then, once that is
    /// not enough, bent ones by their distance from the goal, then those that are twisted too.
    fn starts<'a>(&'a self, effort: &'a Effort) -> impl Iterator<Item = Vec<ShootingNode>> + 'a {
        let shape = move |moment: Vector3<f64>| {
            effort.spend(self.elements.len())?;
            Some(self.rod.natural(&self.elements, self.clamp, moment))
        };
        let bent = move |torque: f64| {
            let mut bent = Vec::new();
            for size in BENDING {
                for direction in 0..DIRECTIONS {
                    let (sin, cos) = (TAU * f64::from(direction) / f64::from(DIRECTIONS)).sin_cos();
                    let moment = Vector3::new(size * cos, size * sin, torque);
                    bent.extend(shape(self.clamp.1 * moment));
                }
            }
            let missed = |nodes: &Vec<ShootingNode>| {
                let missed = nodes.last().and_then(|tip| self.goal.missed(tip));
                missed.map_or(f64::MAX, |(missed, _)| missed.norm())
            };
            bent.sort_by(|a, b| missed(a).total_cmp(&missed(b)));
            bent
        };
        let moment = match self.goal {
            Goal::Free { moment, .. } => moment,
            _ => Vector3::zeros(),
        };
        shape(moment).into_iter().chain(TWISTING.into_iter().flat_map(bent))
    }

    /// Continuation from `start` in the loads and in the condition on the end together.
    fn follow(
        &self,
        elements: &[MeshElement],
        start: &ContinuationStart,
        effort: &Effort,
    ) -> Option<Equilibrium> {
        let nodes = self.continued(elements, start, 1.0, effort)?;
        self.finish(elements.to_vec(), nodes, &self.goal, 1.0, effort)
    }

    /// Continuation from `start` to the condition on the end and the part `loads` of the loads.
    fn continued(
        &self,
        elements: &[MeshElement],
        start: &ContinuationStart,
        loads: f64,
        effort: &Effort,
    ) -> Option<Vec<ShootingNode>> {
        let tip = start.nodes.last()?;
        let mut nodes = start.nodes.clone();
        let near = start.factor >= loads && self.goal.missed(tip)?.0.norm() < NEAR_SOLUTION;
        let (mut at, mut step) = (0.0_f64, if near { 1.0 } else { FIRST });
        while at < 1.0 {
            let next = (at + step).min(1.0);
            let goal = self.goal.on_the_way(tip, start.turns, next)?;
            let factor = start.factor + (loads - start.factor) * next;
            let mut trial = nodes.clone();
            if newton(&self.rod, elements, &mut trial, &goal, factor, effort).is_some() {
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

    /// Refines the elements until the solution is resolved, and measures it.
    fn finish(
        &self,
        mut elements: Vec<MeshElement>,
        mut nodes: Vec<ShootingNode>,
        goal: &Goal,
        factor: f64,
        effort: &Effort,
    ) -> Option<Equilibrium> {
        newton(&self.rod, &elements, &mut nodes, goal, factor, effort)?;
        for _ in 0..REFINEMENTS {
            let Some(finer) = self.rod.refined(&elements, &nodes, factor) else { break };
            (elements, nodes) = finer;
            newton(&self.rod, &elements, &mut nodes, goal, factor, effort)?;
        }
        let conjugate_points = index(&self.rod, &elements, &nodes, goal, factor)?;
        let (mut elastic, mut work) = (0.0, 0.0);
        for (element, node) in elements.iter().zip(&nodes) {
            let properties = self.rod.properties(element, factor);
            let reached = node.step(element.from, element.to, properties);
            elastic += reached.elastic;
            work += reached.work + factor * element.end_load.dot(&reached.node.r);
        }
        if let Goal::Free { force, moment: _ } = goal {
            work += force.dot(&nodes.last()?.r);
        }
        let rod = self.rod.clone();
        Some(Equilibrium { rod, elements, nodes, factor, elastic, work, conjugate_points })
    }
}
