use crate::StaticError;
use crate::chain::{Chain, TipHold};
use crate::continuation::{Continuation, ContinuationStart};
use crate::equilibrium::Equilibrium;
use crate::error::finite;
use crate::goal::{EndPlace, EndTurning, Goal};
use crate::mesh::{MeshElement, Scaled};
use crate::rod::{EndCondition, Piece};
use crate::shooting::{Effort, RootHold, Shooting};
use crate::state::State;
use crate::step::ShootingNode;
use crate::target::Target;
use nalgebra::{Isometry3, Point3, Vector3};
use std::f64::consts::TAU;

/// Moments that bend the shapes to start from, in units of stiffness over length.
const BENDING: [f64; 4] = [1.5, 3.0, 5.0, 7.0];
/// Number of directions in which the shapes to start from are bent.
const DIRECTIONS: u32 = 8;
/// Stiffness of the spring that holds an end, in units of the rod's stiffness.
const STIFF: f64 = 100.0;
/// Number of solves with that spring; each correction of its anchor reduces the distance of the end
/// from its place by about the factor `STIFF`.
const HELD: usize = 4;
/// Cost of a minimisation of the energy, in steps along its elements.
const RELAX: usize = 10;
/// How often the segments of a minimum of the energy are halved, at most, until Newton's method
/// leads from it to the rod.
const HALVINGS: usize = 3;
/// Torques that twist the bent shapes to start from, in units of stiffness over length.
const TWISTING: [f64; 3] = [0.0, 2.0, -2.0];

/// A rod clamped at its root, loaded along its length, with a condition on its far end.
///
/// Inextensible and unshearable; dead loads; stiffnesses and natural curvature may vary along the
/// rod and jump between pieces. The six unknowns are force and moment at the clamp.
#[derive(Debug, Clone)]
pub struct Problem {
    pub(crate) rod: Scaled,
    pub(crate) root: RootHold,
    pub(crate) goal: Goal,
    /// Mesh from which every search for a solution starts.
    elements: Vec<MeshElement>,
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
        let elements = rod.elements([goal.force_on_end().norm(), goal.moment_on_end().norm()])?;
        let (r, q) = (clamp.translation.vector / rod.length, clamp.rotation);
        Ok(Self { root: RootHold { r, q, hinged: false }, rod, goal, elements })
    }

    /// The same rod in a ball joint at its root instead of a clamp; searches start from the frame
    /// that the clamp had. The end must be held, else the rod has no definite place.
    ///
    /// # Errors
    /// [`StaticError::Loose`] for a free end.
    pub fn hinged(mut self) -> Result<Self, StaticError> {
        if self.goal.is_free() {
            return Err(StaticError::Loose);
        }
        self.root.hinged = true;
        Ok(self)
    }

    /// Finds an equilibrium, stable if one is found. No random numbers.
    ///
    /// Where the end is free and no moment acts on it, the energy is minimised from the natural
    /// shape. Else, and if that fails, by continuation from the natural shape without loads but
    /// bent by the moment on the end, and from bent shapes, the nearest to the end condition first;
    /// from an unstable equilibrium the energy is minimised further.
    ///
    /// # Errors
    /// [`StaticError::NotFound`] if no start leads to an equilibrium.
    pub fn solve(&self) -> Result<Equilibrium, StaticError> {
        let effort = Effort::new();
        self.any(&effort).ok_or(StaticError::NotFound)
    }

    /// The equilibria that all starts lead to, also with up to `turns` whole turns of the end about
    /// its tangent to either side, and the equilibrium of [`Problem::solve`], sorted by energy.
    /// Equilibria that differ by a turn or a reflection of the whole rod are listed once. There may
    /// be more.
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
                if let Some(one) = self.continuation(&effort).follow(&self.elements, &start)
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
    /// and clamp with another end condition, or one of [`Problem::bent`]. Loads grow along the path
    /// from the fraction that acts on `start`.
    ///
    /// # Errors
    /// [`StaticError::NotFound`] if the continuation does not reach the goal.
    pub fn solve_from(&self, start: &Equilibrium) -> Result<Equilibrium, StaticError> {
        let nodes = start.nodes.clone();
        let start_at = ContinuationStart { nodes, factor: start.factor, turns: 0.0 };
        self.continuation(&Effort::new())
            .follow(&start.elements, &start_at)
            .ok_or(StaticError::NotFound)
    }

    /// The rod without its loads and its end condition, bent by the dead `moment` (N m, world
    /// frame) on the end: a shape to start from with [`Problem::solve_from`].
    ///
    /// # Errors
    /// [`StaticError::NotFound`] if the rod bends too sharply to be resolved.
    pub fn bent(&self, moment: &Vector3<f64>) -> Result<Equilibrium, StaticError> {
        let moment = moment / self.rod.energy();
        let elements = self.rod.elements([0.0, moment.norm()])?;
        let nodes = self.rod.natural(&elements, (self.root.r, self.root.q), moment);
        let goal = Goal {
            place: EndPlace::Free { force: Vector3::zeros() },
            turning: EndTurning::Free { moment },
        };
        let root = RootHold { hinged: false, ..self.root };
        let free = Continuation { rod: &self.rod, root, goal: &goal, effort: &Effort::new() };
        free.finish(elements, nodes, 0.0).ok_or(StaticError::NotFound)
    }

    /// The equilibrium near the states `guess` at ascending arc lengths (m, the first of them
    /// zero), by Newton's method without continuation; it may be unstable.
    ///
    /// # Errors
    /// [`StaticError::NotFound`] if Newton's method does not converge or the guess is empty.
    pub fn solve_near(&self, guess: &[(f64, State)]) -> Result<Equilibrium, StaticError> {
        let mut guess = guess.iter().map(|(s, state)| (s / self.rod.length, state)).peekable();
        let (_, first) = guess.next().ok_or(StaticError::NotFound)?;
        let elements = &self.elements;
        let mut first = self.rod.scale(first);
        first.correct(&self.root.missed(&first));
        let mut nodes = vec![first];
        // Integrate each element from the last guess in it.
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
        // Refine the elements for the guess, before Newton's method leaves it.
        let finer = self.rod.refined(elements, &nodes, 1.0);
        let (elements, nodes) = finer.unwrap_or_else(|| (elements.clone(), nodes));
        let found = self.continuation(&Effort::new()).finish(elements, nodes, 1.0);
        found.ok_or(StaticError::NotFound)
    }

    /// Continuation to the goal of the problem.
    pub(crate) fn continuation<'a>(&'a self, effort: &'a Effort) -> Continuation<'a> {
        Continuation { rod: &self.rod, root: self.root, goal: &self.goal, effort }
    }

    /// The equations of the problem under its whole loads.
    pub(crate) fn shooting(&self) -> Shooting<'_> {
        Shooting { rod: &self.rod, root: self.root, goal: &self.goal, factor: 1.0 }
    }

    /// The equilibrium of [`Problem::solve`], `None` if no start leads to one.
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
        let free = self.goal.is_free();
        let stable = |found: &Option<Equilibrium>| found.as_ref().is_some_and(|f| f.is_stable());
        // A free end: minimise the energy from the start.
        if free {
            let found = self.descend(elements, &start.nodes, effort);
            if stable(&found) {
                return found;
            }
        }
        // Continuation in the loads and the end condition.
        let found = self.continuation(effort).follow(elements, start);
        if stable(&found) {
            return found;
        }
        // From a saddle, or where the continuation fails, minimise the energy.
        let (elements, nodes) = match &found {
            Some(saddle) => (&saddle.elements, saddle.nodes.clone()),
            // Where the loads block the continuation, they are applied after it.
            None if free => (elements, start.nodes.clone()),
            None => (elements, self.continuation(effort).continued(elements, start, 0.0)?),
        };
        let down = self.descend(elements, &nodes, effort).filter(Equilibrium::is_stable);
        down.or_else(|| self.around(elements, &nodes, effort)).or(found)
    }

    /// The equilibrium reached by perturbing the end condition and removing the perturbation again.
    /// Near a buckling load the rod in segments may be stable where the rod is not; perturbed, both
    /// buckle.
    fn around(
        &self,
        elements: &[MeshElement],
        nodes: &[ShootingNode],
        effort: &Effort,
    ) -> Option<Equilibrium> {
        let pushed = Self { goal: self.goal.pushed(), ..self.clone() };
        let start = ContinuationStart { nodes: nodes.to_vec(), factor: 1.0, turns: 0.0 };
        let nodes = match self.goal.is_free() {
            true => start.nodes,
            false => pushed.continuation(effort).continued(elements, &start, 1.0)?,
        };
        let leaning = pushed.descend(elements, &nodes, effort)?;
        let start = ContinuationStart { nodes: leaning.nodes, factor: 1.0, turns: 0.0 };
        self.continuation(effort).follow(&leaning.elements, &start)
    }

    /// The equilibrium near the minimum of the energy that the rod in segments reaches from
    /// `nodes`, which meet the end condition. Where its segments are too long to lead Newton's
    /// method to the rod, they are halved. `None` also for a moment on the end, which has no
    /// energy, and for rods in a joint at the root or on a line at the end.
    fn descend(
        &self,
        elements: &[MeshElement],
        nodes: &[ShootingNode],
        effort: &Effort,
    ) -> Option<Equilibrium> {
        let mut elements = elements.to_vec();
        let mut nodes = self.settled(&elements, nodes, effort)?;
        for _ in 0..HALVINGS {
            let found = self.continuation(effort).finish(elements.clone(), nodes.clone(), 1.0);
            if found.is_some() {
                return found;
            }
            (elements, nodes) = self.rod.halved(&elements, &nodes, 1.0);
            nodes = self.settled(&elements, &nodes, effort)?;
        }
        self.continuation(effort).finish(elements, nodes, 1.0)
    }

    /// The nodes of the rod in segments at rest, by [`Problem::descend`].
    fn settled(
        &self,
        elements: &[MeshElement],
        nodes: &[ShootingNode],
        effort: &Effort,
    ) -> Option<Vec<ShootingNode>> {
        let rod = &self.rod;
        if self.root.hinged || self.goal.moment_on_end() != Vector3::zeros() {
            return None;
        }
        let RootHold { r, q, .. } = self.root;
        // The rod in segments, with the same elements and the same end condition.
        let clamp = Isometry3::from_parts((r * rod.length).into(), q);
        let lengths: Vec<_> =
            elements.iter().map(|e| (e.piece, (e.to - e.from) * rod.length)).collect();
        let mut chain = Chain::cut(&clamp, rod.pieces(), &lengths).ok()?;
        let last = elements.len();
        let place = match self.goal.place {
            EndPlace::Free { force } => {
                chain.forces[last] += force * rod.force();
                None
            }
            EndPlace::Held { position } => Some(position),
            EndPlace::OnLine { .. } => return None,
        };
        chain.tip = match self.goal.turning {
            EndTurning::Free { .. } => TipHold::Free,
            EndTurning::Tangent { .. } => TipHold::Aligned,
            EndTurning::Held { .. } => TipHold::Held,
        };
        let mut shape = chain.shape(nodes.iter().map(|node| node.q).collect());
        let mut pull = nodes.last()?.n * rod.force();
        let stiffness = STIFF * chain.stiffness() + 10.0 * pull.norm() / rod.length;
        let mut rest = None;
        // A spring holds the end, its anchor moved by the stretch of the spring (Hestenes 1969).
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
        // States of the nodes; the force from tip to clamp by the balance of loads.
        let states = chain.states(&rest?);
        let mut nodes: Vec<ShootingNode> = states.iter().map(|state| rod.scale(state)).collect();
        nodes[last].n = match self.goal.place {
            EndPlace::Free { force } => force,
            _ => pull / rod.force(),
        };
        for (i, element) in elements.iter().enumerate().rev() {
            let middle = 0.5 * (element.from + element.to);
            let load = rod.properties(element, 1.0)(middle).load * (element.to - element.from);
            nodes[i].n = nodes[i + 1].n + element.end_load + load;
        }
        Some(nodes)
    }

    /// Shapes to start from: the natural one, bent by the moment on the end, then, if that is not
    /// enough, bent ones by their distance from the goal, then those that are twisted too.
    fn starts<'a>(&'a self, effort: &'a Effort) -> impl Iterator<Item = Vec<ShootingNode>> + 'a {
        let shape = move |moment: Vector3<f64>| {
            effort.spend(self.elements.len())?;
            Some(self.rod.natural(&self.elements, (self.root.r, self.root.q), moment))
        };
        let bent = move |torque: f64| {
            let mut bent = Vec::new();
            for size in BENDING {
                for direction in 0..DIRECTIONS {
                    let (sin, cos) = (TAU * f64::from(direction) / f64::from(DIRECTIONS)).sin_cos();
                    let moment = Vector3::new(size * cos, size * sin, torque);
                    bent.extend(shape(self.root.q * moment));
                }
            }
            let missed = |nodes: &Vec<ShootingNode>| {
                let missed = nodes.last().and_then(|tip| self.goal.missed(tip));
                missed.map_or(f64::MAX, |(missed, _)| missed.norm())
            };
            bent.sort_by(|a, b| missed(a).total_cmp(&missed(b)));
            bent
        };
        shape(self.goal.moment_on_end()).into_iter().chain(TWISTING.into_iter().flat_map(bent))
    }
}
