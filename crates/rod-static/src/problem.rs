use crate::StaticError;
use crate::chain::Chain;
use crate::equilibrium::Equilibrium;
use crate::error::finite;
use crate::goal::Goal;
use crate::mesh::{Element, Scaled};
use crate::rod::{End, Piece};
use crate::shooting::newton;
use crate::stability::index;
use crate::state::State;
use crate::step::Node;
use crate::target::Target;
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use std::f64::consts::TAU;
use std::iter::once;

/// First and shortest step of a continuation, in parts of the way.
const FIRST: f64 = 0.25;
const SHORTEST: f64 = 1e-3;
/// A way short enough to be tried in one step, in lengths, radians and stiffness by length.
const NEAR: f64 = 0.1;
/// How often the elements are split before the solution counts as not resolved.
const REFINEMENTS: usize = 4;
/// Moments that bend the shapes to start from, in units of stiffness by length.
const BENDING: [f64; 4] = [1.5, 3.0, 5.0, 7.0];
/// Directions in which they bend.
const DIRECTIONS: u32 = 8;
/// Segments of the chain whose minimum is a start.
const SEGMENTS: usize = 400;
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
}

/// Where a continuation begins: a shape, the part of the loads on it, and whole turns of the end
/// about its tangent on the way.
struct Start {
    nodes: Vec<Node>,
    factor: f64,
    turns: f64,
}

impl Problem {
    /// The rod made of `pieces`, in order from the clamp, whose pose is `clamp`: its z axis is the
    /// tangent.
    ///
    /// # Errors
    /// No pieces, lengths or stiffnesses that are not positive, numbers that are not finite, and
    /// an end farther from the clamp than the rod is long.
    pub fn new(clamp: &Isometry3<f64>, pieces: Vec<Piece>, end: End) -> Result<Self, StaticError> {
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
        Ok(Self { clamp: (clamp.translation.vector / rod.length, clamp.rotation), rod, goal })
    }

    /// An equilibrium, stable if one is found: by continuation from the natural shape without
    /// loads; if that fails or leads to an unstable one, from the minimum of the energy of a
    /// [`Chain`], where the end is free or in a ball joint, and then from bent shapes, the nearest
    /// to the condition on the end first. No random numbers.
    ///
    /// # Errors
    /// [`StaticError::NotFound`] if no start leads to an equilibrium.
    pub fn solve(&self) -> Result<Equilibrium, StaticError> {
        let elements = self.rod.elements();
        let mut unstable = None;
        for (tried, nodes) in self.starts(&elements).enumerate() {
            let way = || self.follow(&elements, &Start { nodes, factor: 0.0, turns: 0.0 });
            // The first start is the natural shape; where no way leads from it, energy does.
            let found = if tried == 1 { self.minimum().or_else(way) } else { way() };
            match found {
                Some(found) if found.is_stable() => return Ok(found),
                Some(found) => unstable = unstable.or(Some(found)),
                None => {}
            }
        }
        unstable.ok_or(StaticError::NotFound)
    }

    /// The equilibria that all starts lead to, also with up to `turns` whole turns of the end
    /// about its tangent to either side, sorted by energy; none twice. There may be more.
    #[must_use]
    pub fn solutions(&self, turns: u16) -> Vec<Equilibrium> {
        let elements = self.rod.elements();
        let turns: Vec<f64> = (0..=turns)
            .flat_map(|k| if k == 0 { vec![0.0] } else { vec![f64::from(k), -f64::from(k)] })
            .collect();
        let mut found: Vec<Equilibrium> = Vec::new();
        for nodes in self.starts(&elements) {
            for &turns in &turns {
                let start = Start { nodes: nodes.clone(), factor: 0.0, turns };
                if let Some(one) = self.follow(&elements, &start)
                    && !found.iter().any(|other| same(other, &one))
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
        let start_at = Start { nodes, factor: start.factor, turns: 0.0 };
        self.follow(&start.elements, &start_at).ok_or(StaticError::NotFound)
    }

    /// The rod without its loads and its condition on the end, bent by the dead `moment` (N m,
    /// world frame) on the end: a shape to start from with [`Problem::solve_from`].
    ///
    /// # Errors
    /// [`StaticError::NotFound`] if it is too much to be resolved.
    pub fn bent(&self, moment: &Vector3<f64>) -> Result<Equilibrium, StaticError> {
        let elements = self.rod.elements();
        let nodes = self.rod.natural(&elements, self.clamp, moment / self.rod.energy());
        let goal = Goal::Free { force: Vector3::zeros(), moment: moment / self.rod.energy() };
        self.finish(elements, nodes, &goal, 0.0).ok_or(StaticError::NotFound)
    }

    /// The equilibrium near the states `guess` at ascending arc lengths, m, the first of them zero:
    /// Newton's method at once, also for an unstable one.
    ///
    /// # Errors
    /// [`StaticError::NotFound`] if Newton's method does not converge or the guess is empty.
    pub fn solve_near(&self, guess: &[(f64, State)]) -> Result<Equilibrium, StaticError> {
        let mut guess = guess.iter().map(|(s, state)| (s / self.rod.length, state)).peekable();
        let (_, first) = guess.next().ok_or(StaticError::NotFound)?;
        let elements = self.rod.elements();
        let (r, q) = self.clamp;
        let mut nodes = vec![Node { r, q, ..self.rod.scale(first) }];
        for element in &elements {
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
        let finer = self.rod.refined(&elements, &nodes, 1.0);
        let (elements, nodes) = finer.unwrap_or((elements, nodes));
        self.finish(elements, nodes, &self.goal, 1.0).ok_or(StaticError::NotFound)
    }

    /// The equilibrium near the minimum of the energy of the rod in segments.
    fn minimum(&self) -> Option<Equilibrium> {
        let (r, q) = self.clamp;
        let clamp = Isometry3::from_parts((r * self.rod.length).into(), q);
        let mut chain = Chain::new(&clamp, self.rod.pieces(), SEGMENTS).ok()?;
        let last = chain.segment_count();
        match self.goal {
            Goal::Free { force, moment } if moment == Vector3::zeros() => {
                let mut forces = chain.forces().to_vec();
                forces[last] += force * self.rod.force();
                chain.set_forces(&forces).ok()?;
            }
            Goal::Position { position, .. } => {
                let place = Point3::from(position * self.rod.length);
                chain.set_targets(&[Target::held(last, place)]).ok()?;
            }
            _ => return None,
        }
        let rest = chain.solve().ok()?;
        let guess = chain.arc_lengths().into_iter().zip(chain.states(&rest));
        self.solve_near(&guess.collect::<Vec<_>>()).ok()
    }

    /// The shapes to start from: the natural one, then, once that is not enough, bent ones by their
    /// distance from the goal, then those that are twisted too.
    fn starts<'a>(&'a self, elements: &'a [Element]) -> impl Iterator<Item = Vec<Node>> + 'a {
        let shape = |m: Vector3<f64>| self.rod.natural(elements, self.clamp, self.clamp.1 * m);
        let bent = move |torque: f64| {
            let mut bent = Vec::new();
            for size in BENDING {
                for direction in 0..DIRECTIONS {
                    let (sin, cos) = (TAU * f64::from(direction) / f64::from(DIRECTIONS)).sin_cos();
                    bent.push(shape(Vector3::new(size * cos, size * sin, torque)));
                }
            }
            let missed = |nodes: &Vec<Node>| {
                let missed = nodes.last().and_then(|tip| self.goal.missed(tip));
                missed.map_or(f64::MAX, |(missed, _)| missed.norm())
            };
            bent.sort_by(|a, b| missed(a).total_cmp(&missed(b)));
            bent
        };
        once(shape(Vector3::zeros())).chain(TWISTING.into_iter().flat_map(bent))
    }

    /// Continuation from `start` in the loads and in the condition on the end together.
    fn follow(&self, elements: &[Element], start: &Start) -> Option<Equilibrium> {
        let tip = start.nodes.last()?;
        let mut nodes = start.nodes.clone();
        let near = start.factor >= 1.0 && self.goal.missed(tip)?.0.norm() < NEAR;
        let (mut at, mut step) = (0.0_f64, if near { 1.0 } else { FIRST });
        while at < 1.0 {
            let next = (at + step).min(1.0);
            let goal = self.goal.on_the_way(tip, start.turns, next)?;
            let factor = start.factor + (1.0 - start.factor) * next;
            let mut trial = nodes.clone();
            if newton(&self.rod, elements, &mut trial, &goal, factor).is_some() {
                (nodes, at, step) = (trial, next, 2.0 * step);
            } else {
                step *= 0.5;
                if step < SHORTEST {
                    return None;
                }
            }
        }
        self.finish(elements.to_vec(), nodes, &self.goal, 1.0)
    }

    /// Refines the elements until the solution is resolved, and measures it.
    fn finish(
        &self,
        mut elements: Vec<Element>,
        mut nodes: Vec<Node>,
        goal: &Goal,
        factor: f64,
    ) -> Option<Equilibrium> {
        newton(&self.rod, &elements, &mut nodes, goal, factor)?;
        for _ in 0..REFINEMENTS {
            let Some(finer) = self.rod.refined(&elements, &nodes, factor) else { break };
            (elements, nodes) = finer;
            newton(&self.rod, &elements, &mut nodes, goal, factor)?;
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

/// Whether two equilibria are one: the same force and moment at the clamp.
fn same(a: &Equilibrium, b: &Equilibrium) -> bool {
    let (a, b) = (&a.nodes[0], &b.nodes[0]);
    (a.m - b.m).norm() < 1e-6 * (1.0 + a.m.norm()) && (a.n - b.n).norm() < 1e-6 * (1.0 + a.n.norm())
}
