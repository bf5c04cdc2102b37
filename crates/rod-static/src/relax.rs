use crate::band::Follow;
use crate::chain::Chain;
use crate::newton::NewtonStep;
use crate::segment::Blocks;
use crate::shape::Shape;
use crate::target::Target;
use crate::trial::TrialShape;
use crate::{State, StaticError};
use nalgebra::{UnitQuaternion, Vector3};
use rapunzel_fiber::so3::hat;
use rayon::prelude::*;

/// Largest number of Newton steps of one attempt.
const MOST_RELAXATIONS: usize = 300;
/// Newton steps with held nodes as constraints, before springs pull them to their places.
const AT_ONCE: usize = 20;
/// Stiffnesses of the springs that pull held nodes to their places, in units of the rod's
/// stiffness.
const SPRINGS: [f64; 4] = [3.0, 30.0, 300.0, 3000.0];
/// Size of a step, rad, after which the iteration ends: the next one is its square.
const SMALL_CHANGE: f64 = 1e-8;
/// Size of a step, rad, below which its merit is not tested.
const LOCAL: f64 = 1e-3;
/// Size of a step of a shifted matrix, rad, below which a direction of negative curvature is tried.
const STALLED: f64 = 0.3;
/// Value of `STALLED` with targets, whose directions of negative curvature are curved.
const STALLED_HELD: f64 = 0.03;
/// Largest rotation of a node in a step, rad.
const LARGEST: f64 = 1.5;
/// Fraction of the decrease predicted by the slope that a step must bring (Armijo 1966).
const ENOUGH: f64 = 1e-4;
/// Rounding error of an energy, relative to it.
const RELAX_ROUNDING: f64 = 1e-13;
/// Shortest fraction of a step in the line search.
const SHORTEST_LINE_STEP: f64 = 1e-6;
/// Number of whole steps that are taken on trial where the first of them raises the merit.
const AHEAD: usize = 4;
/// Trial rotations along a direction of negative curvature, rad.
const FALLS: [f64; 6] = [0.01, 0.03, 0.1, 0.3, 0.6, 1.0];
/// Rotation along a direction of negative curvature from which whole steps are tried, rad.
const FAR_STEP: f64 = 0.3;
/// Fraction of the following forces that is applied first.
const FIRST: f64 = 0.25;
/// Smallest increment of that fraction.
const LEAST: f64 = 1e-3;
/// Largest number of Newton steps for each fraction.
const FEW_STEPS: usize = 12;

/// An equilibrium of a [`Chain`]: a minimum of the energy, if no following loads act.
#[derive(Debug, Clone)]
pub struct Rest {
    /// Shape of the chain in equilibrium.
    pub shape: Shape,
    /// Forces of the targets on their nodes, N, world frame, in the order of the targets.
    pub pulls: Vec<Vector3<f64>>,
    /// Number of Newton steps that were taken.
    pub iterations: usize,
}

impl Chain {
    /// The equilibrium that is reached from the natural shape.
    ///
    /// # Errors
    /// As [`Chain::relax`].
    pub fn solve(&self) -> Result<Rest, StaticError> {
        self.relax(&self.natural_shape())
    }

    /// The equilibrium that is reached from `start`, a shape of this chain, also one from before
    /// its clamp or its loads changed.
    ///
    /// Newton's method on the energy (3.130) and (3.135), corrected: the energy itself is
    /// minimized, not its square. The pivots of the Hessian tell whether it is definite; where it
    /// is not, it is shifted, and at a saddle a direction of falling energy is taken. So the
    /// equilibrium is stable, or neutral where all turns of it about an axis are equilibria too.
    /// Places that hold nodes enter by Lagrange's multipliers. Following forces and couples, which
    /// have no energy, are applied in parts. Cost: about half a microsecond for each segment and
    /// step; less than ten steps from a natural shape, three from a shape nearby.
    ///
    /// # Errors
    /// A shape of another number of nodes, and [`StaticError::NotConverged`].
    pub fn relax(&self, start: &Shape) -> Result<Rest, StaticError> {
        let frames = self.frames_at_clamp(start)?;
        if self.is_followed() { self.follow(frames) } else { self.minimize(frames) }
    }

    /// The equilibrium next to `start`, by a few steps of Newton's method alone: on the branch of
    /// equilibria that the start is near to, stable or not. Where there is none it tells so at the
    /// cost of a dozen steps; [`Chain::relax`] would look for others.
    ///
    /// # Errors
    /// As [`Chain::relax`].
    pub fn relax_nearby(&self, start: &Shape) -> Result<Rest, StaticError> {
        let mut frames = self.frames_at_clamp(start)?;
        let mut pulls = vec![Vector3::zeros(); self.targets.len()];
        let mut iterations = 0;
        let step = self.balance(&mut frames, &mut pulls, 1.0, &mut iterations);
        if step < SMALL_CHANGE {
            Ok(Rest { shape: self.shape(frames), pulls, iterations })
        } else {
            Err(StaticError::NotConverged { iterations, step })
        }
    }

    /// The frames of a shape from before the clamp turned, turned with it.
    fn frames_at_clamp(&self, start: &Shape) -> Result<Vec<UnitQuaternion<f64>>, StaticError> {
        self.check(start)?;
        let moved = self.clamp.rotation * start.frames[0].inverse();
        // Normalized: a norm that is off by rounding would square from one warm start to the next.
        let turned = |frame: &UnitQuaternion<f64>| {
            UnitQuaternion::new_normalize((moved * frame).into_inner())
        };
        Ok(start.frames.iter().map(turned).collect())
    }

    /// Relaxes each chain from its own shape, in parallel; the results do not depend on the number
    /// of threads.
    ///
    /// # Errors
    /// A number of starts other than one for each chain; for each chain the errors of
    /// [`Chain::relax`].
    pub fn relax_all(
        chains: &[Self],
        starts: &[Shape],
    ) -> Result<Vec<Result<Rest, StaticError>>, StaticError> {
        let (given, chains_given) = (starts.len(), chains.len());
        if given != chains_given {
            return Err(StaticError::NotOneStartEach { given, chains: chains_given });
        }
        Ok(chains.par_iter().zip(starts).map(|(chain, start)| chain.relax(start)).collect())
    }

    /// States of the nodes in equilibrium. Moments come from the balance of the nodes; forces,
    /// which are constant in each segment, are the mean of both segments, extrapolated at the ends.
    #[must_use]
    pub fn states(&self, rest: &Rest) -> Vec<State> {
        let shape = &rest.shape;
        let carried = self.carried(&shape.frames, 1.0, &rest.pulls);
        let blocks = TrialShape::new(self, shape.frames.clone(), &carried).blocks(self, &carried);
        let state = |i: usize| {
            let moment = if i == 0 { -blocks[0].gradient[0] } else { blocks[i - 1].gradient[1] };
            let (frame, position) = (shape.frames[i], shape.positions[i]);
            let force = Self::force_at(&carried, i);
            State { position, frame: frame.to_rotation_matrix(), force, moment: frame * moment }
        };
        (0..=self.segments.len()).map(state).collect()
    }

    /// The force at a node from those in the segments.
    pub(crate) fn force_at(carried: &[Vector3<f64>], node: usize) -> Vector3<f64> {
        let last = carried.len() - 1;
        match node {
            _ if last == 0 => carried[0],
            0 => 1.5 * carried[0] - 0.5 * carried[1],
            i if i > last => 1.5 * carried[last] - 0.5 * carried[last - 1],
            i => 0.5 * (carried[i - 1] + carried[i]),
        }
    }

    fn minimize(&self, frames: Vec<UnitQuaternion<f64>>) -> Result<Rest, StaticError> {
        let free = vec![Vector3::zeros(); self.targets.len()];
        if !self.targets.iter().any(Target::is_held) {
            return self.descend(frames, free, MOST_RELAXATIONS);
        }
        if let Ok(rest) = self.descend(frames.clone(), free, AT_ONCE) {
            return Ok(rest);
        }
        // From afar, springs of growing stiffness lead the nodes to where they are held.
        let mut rest = Rest { shape: self.shape(frames), pulls: Vec::new(), iterations: AT_ONCE };
        let unit = self.stiffness();
        for stiffness in SPRINGS {
            let mut soft = self.clone();
            for target in soft.targets.iter_mut().filter(|target| target.is_held()) {
                target.stiffness = stiffness * unit;
            }
            let free = vec![Vector3::zeros(); self.targets.len()];
            let before = rest.iterations;
            rest = soft.descend(rest.shape.frames, free, MOST_RELAXATIONS)?;
            rest.iterations += before;
        }
        let before = rest.iterations;
        let held = self.descend(rest.shape.frames, rest.pulls, MOST_RELAXATIONS)?;
        Ok(Rest { iterations: held.iterations + before, ..held })
    }

    /// Scale of the whole rod's stiffness against a force on its end, N/m, from bending and loads.
    pub(crate) fn stiffness(&self) -> f64 {
        let length: f64 = self.segments.iter().map(|segment| segment.length).sum();
        let bending = self.segments.iter().map(|segment| segment.stiffness.max());
        let loads: f64 = self.forces.iter().map(Vector3::norm).sum();
        bending.fold(0.0, f64::max) / length.powi(3) + loads / length
    }

    /// The minimum that is reached in at most `most` steps; `pulls` are the initial forces of the
    /// targets.
    fn descend(
        &self,
        frames: Vec<UnitQuaternion<f64>>,
        mut pulls: Vec<Vector3<f64>>,
        most: usize,
    ) -> Result<Rest, StaticError> {
        let dead = self.carried(&frames, 0.0, &[]);
        let mut now = TrialShape::new(self, frames, &dead);
        // The merit: the energy, plus the distances of held nodes from their places weighted more
        // than the pulls.
        let mut weight = 0.0_f64;
        let mut size = f64::INFINITY;
        let stalled = if self.targets.is_empty() { STALLED } else { STALLED_HELD };
        let held = self.targets.iter().any(Target::is_held);
        for iterations in 0..most {
            self.stretch_springs(&now, &mut pulls);
            let carried = self.carried(&now.frames, 0.0, &pulls);
            let blocks = now.blocks(self, &carried);
            let motions = if self.targets.is_empty() { Vec::new() } else { now.motions(self) };
            let Some(newton) = NewtonStep::of(self, &blocks, &now.gaps, &motions, None) else {
                break;
            };
            size = newton.size();
            if newton.shift == 0.0 && size < SMALL_CHANGE {
                now = now.moved(self, &dead, &newton.step, 1.0);
                update(&mut pulls, &newton.pulls, 1.0);
                return Ok(Rest { shape: self.shape(now.frames), pulls, iterations });
            }
            for (pull, change) in pulls.iter().zip(&newton.pulls) {
                weight = weight.max(2.0 * (pull + change).norm());
            }
            let merit = |trial: &TrialShape| trial.energy + weight * trial.missed(self);
            let before = merit(&now);
            // At a saddle: go down a direction of negative curvature.
            if let Some(falling) = newton.falling.as_ref().filter(|_| size < stalled) {
                let lowest = self.lowest(&now, &dead, falling, merit);
                let deeper =
                    |trial: &TrialShape| merit(trial) < before - RELAX_ROUNDING * before.abs();
                if let Some(lowest) = lowest.filter(deeper) {
                    now = lowest;
                    continue;
                }
                if size < SMALL_CHANGE && !held {
                    // A round rod that has buckled may do so in any plane: rounding alone makes
                    // this a direction of falling energy.
                    return Ok(Rest { shape: self.shape(now.frames), pulls, iterations });
                }
            }
            // Line search: halve the step until the merit falls enough.
            let mut part = (LARGEST / size).min(1.0);
            if newton.shift == 0.0 && size < LOCAL {
                now = now.moved(self, &dead, &newton.step, 1.0);
            } else {
                let slope = self.slope(&blocks, &newton, &now, &pulls, weight);
                let low = |part: f64| before + ENOUGH * part * slope.min(0.0);
                let mut next = now.moved(self, &dead, &newton.step, part);
                if self.targets.is_empty() && next.energy > low(part) {
                    next = self.ahead(&next, &dead, low(part)).unwrap_or(next);
                }
                while merit(&next) > low(part) && part >= SHORTEST_LINE_STEP {
                    part *= 0.5;
                    next = now.moved(self, &dead, &newton.step, part);
                }
                now = next;
            }
            update(&mut pulls, &newton.pulls, part);
        }
        Err(StaticError::NotConverged { iterations: most, step: size })
    }

    /// The lowest of several shapes along a direction in which the energy falls.
    fn lowest(
        &self,
        now: &TrialShape,
        dead: &[Vector3<f64>],
        falling: &[Vector3<f64>],
        merit: impl Fn(&TrialShape) -> f64,
    ) -> Option<TrialShape> {
        let largest = falling.iter().map(Vector3::norm).fold(0.0, f64::max);
        let both = |size: f64| [size, -size].map(|s| now.moved(self, dead, falling, s / largest));
        let deeper = |a: &TrialShape, b: &TrialShape| merit(a).total_cmp(&merit(b));
        let lowest = FALLS.into_iter().flat_map(both).min_by(deeper)?;
        if !self.targets.is_empty() {
            return Some(lowest);
        }
        let low = merit(&lowest).min(merit(now));
        let far = both(FAR_STEP).into_iter().filter_map(|trial| self.ahead(&trial, dead, low));
        far.min_by(deeper).or(Some(lowest))
    }

    /// The shape that a few whole steps from `start` lead to, without targets, if its energy is
    /// below `low`: along a curved valley, as of a round rod that may buckle in any plane, the
    /// first step climbs the side of the valley, and the next ones return.
    fn ahead(&self, start: &TrialShape, dead: &[Vector3<f64>], low: f64) -> Option<TrialShape> {
        let mut trial = start.clone();
        for _ in 0..AHEAD {
            let blocks = trial.blocks(self, dead);
            let newton = NewtonStep::of(self, &blocks, &trial.gaps, &[], None)?;
            let part = (LARGEST / newton.size()).min(1.0);
            trial = trial.moved(self, dead, &newton.step, part);
            if trial.energy <= low {
                return Some(trial);
            }
        }
        None
    }

    /// Derivative of the merit along a Newton step.
    fn slope(
        &self,
        blocks: &[Blocks],
        newton: &NewtonStep,
        now: &TrialShape,
        pulls: &[Vector3<f64>],
        weight: f64,
    ) -> f64 {
        let along = blocks.iter().enumerate().fold(0.0, |sum, (i, block)| {
            let before = if i > 0 { block.gradient[0].dot(&newton.step[i - 1]) } else { 0.0 };
            sum + before + block.gradient[1].dot(&newton.step[i])
        });
        // The pulls of held nodes are in the gradient, but not in the energy.
        let held = self.targets.iter().zip(&now.gaps).zip(pulls).filter(|((t, _), _)| t.is_held());
        along - held.map(|((_, gap), pull)| gap.dot(pull) + weight * gap.norm()).sum::<f64>()
    }

    pub(crate) fn stretch_springs(&self, now: &TrialShape, pulls: &mut [Vector3<f64>]) {
        for ((target, gap), pull) in self.targets.iter().zip(&now.gaps).zip(pulls) {
            if !target.is_held() {
                *pull = -target.stiffness * gap;
            }
        }
    }

    /// Applies the following loads in fractions, with Newton's method after each.
    fn follow(&self, mut frames: Vec<UnitQuaternion<f64>>) -> Result<Rest, StaticError> {
        let mut pulls = vec![Vector3::zeros(); self.targets.len()];
        let (mut at, mut step, mut iterations) = (0.0_f64, FIRST, 0);
        // From a shape nearby, all at once.
        let mut next = 1.0;
        loop {
            let (mut trial, mut held) = (frames.clone(), pulls.clone());
            let size = self.balance(&mut trial, &mut held, next, &mut iterations);
            if size < SMALL_CHANGE {
                (frames, pulls) = (trial, held);
                if next >= 1.0 {
                    return Ok(Rest { shape: self.shape(frames), pulls, iterations });
                }
                step *= if next > at { 2.0 } else { 1.0 };
                at = next;
            } else if at == 0.0 && next >= 1.0 {
                let mut dead = self.clone();
                dead.followers.fill(Vector3::zeros());
                dead.tip_couple = Vector3::zeros();
                let rest = dead.minimize(frames)?;
                (frames, pulls) = (rest.shape.frames, rest.pulls);
            } else {
                step *= 0.5;
                if step < LEAST {
                    return Err(StaticError::NotConverged { iterations, step: size });
                }
            }
            next = (at + step).min(1.0);
        }
    }

    /// Newton's method with `factor` times the following loads; returns the last step's size.
    fn balance(
        &self,
        frames: &mut Vec<UnitQuaternion<f64>>,
        pulls: &mut [Vector3<f64>],
        factor: f64,
        iterations: &mut usize,
    ) -> f64 {
        let mut size = f64::INFINITY;
        for _ in 0..FEW_STEPS {
            *iterations += 1;
            let carried = self.carried(frames, factor, pulls);
            let now = TrialShape::new(self, std::mem::take(frames), &carried);
            self.stretch_springs(&now, pulls);
            let carried = self.carried(&now.frames, factor, pulls);
            let blocks = now.blocks(self, &carried);
            let turned = now.frames.iter().zip(&self.followers).map(|(frame, force)| {
                frame.to_rotation_matrix().matrix() * hat(&(-factor * force))
            });
            let couple = factor * self.tip_couple;
            let follow = Follow { couple, turned: turned.collect(), motions: now.motions(self) };
            let step = NewtonStep::of(self, &blocks, &now.gaps, &follow.motions, Some(&follow));
            let Some(newton) = step else { return f64::INFINITY };
            size = newton.size();
            *frames = now.moved(self, &carried, &newton.step, (LARGEST / size).min(1.0)).frames;
            update(pulls, &newton.pulls, 1.0);
            if size < SMALL_CHANGE || !size.is_finite() {
                break;
            }
        }
        size
    }
}

fn update(pulls: &mut [Vector3<f64>], changes: &[Vector3<f64>], part: f64) {
    for (pull, change) in pulls.iter_mut().zip(changes) {
        *pull += part * change;
    }
}
