//! The method of multipliers for rods in contact.

use crate::StaticError;
use crate::assembly::{AssemblyRest, RodAssembly};
use crate::assembly_step::AssemblyStep;
use crate::assembly_trial::{AssemblyTrial, GapSprings};
use crate::gap::GapFunctions;
use crate::loaded_rod::LoadedRod;
use crate::riccati::{RodVariation, RootSupport};
use crate::shape::Shape;
use nalgebra::{Point3, UnitQuaternion, Vector3};
use std::collections::BTreeMap;

/// Part of a rod's length over which the first, soft springs spread a force.
const SOFT: f64 = 0.1;
/// Stiffness of the last springs, in units of that of a segment: stiff against what the contact
/// forces of neighbouring nodes can do, and soft enough that rounded positions give them to six
/// digits.
const STIFFEST: f64 = 200.0;
/// Stiffness, in the same units, of springs that serve as constraints.
const CONSTRAINT: f64 = 1e5;
/// Growth of the stiffness from one stage to the next, at most.
const STAGE_GROWTH: f64 = 100.0;
/// Depth of a contact under all loads, in the smallest radius, that the first springs allow.
const DEEP: f64 = 0.1;
/// Largest number of Newton steps of a stage.
const MOST_STEPS: usize = 300;
/// Largest number of updates of the forces.
const MOST_UPDATES: usize = 100;
/// Size of a step, in rad and lengths of the rod, after which a soft stage ends.
const LOOSE_CHANGE: f64 = 1e-4;
/// Size of a step after which the last stage ends: the next one is its square.
const TIGHT_CHANGE: f64 = 1e-8;
/// Parts of the largest force by which an update of the forces still changes one when Newton's
/// method takes over, in turn.
const SETTLED: [f64; 5] = [0.1, 1e-2, 1e-3, 1e-4, 1e-5];
/// Largest number of its steps.
const FEW_POLISHES: usize = 20;
/// Size of its steps, in rad and lengths of the rod, from which it has failed.
const FAR_POLISH: f64 = 0.01;
/// Part of the largest force by which its last step may still change one.
const FORCE_CHANGE: f64 = 1e-8;
/// Roundings of a position by which a gap is known.
const ROUNDINGS: f64 = 16.0;
/// Largest step, in rad and lengths of the rod.
const LONGEST: f64 = 1.0;
/// Size of a step of a shifted matrix below which a direction of falling energy is tried.
const NEAR_SADDLE: f64 = 0.03;
/// Size of a step below which the merit is not tested.
const CLOSE_STEP: f64 = 1e-6;
/// Part of the slope that a step must bring (Armijo 1966).
const SUFFICIENT: f64 = 1e-4;
/// Rounding error of a merit, relative to it.
const MERIT_ROUNDING: f64 = 1e-13;
/// Shortest part of a step.
const SHORTEST_PART: f64 = 1e-7;
/// Rotations along a direction of falling energy, rad.
const TRIED_FALLS: [f64; 6] = [0.003, 0.01, 0.03, 0.1, 0.3, 1.0];
/// Distance from its start, in its lengths, at which a free rod has moved away.
const AWAY: f64 = 1e3;

/// How a stage ended.
#[derive(Clone, Copy)]
enum SearchStage {
    Rests,
    /// A rod has a freedom that nothing holds.
    Loose(usize),
    /// After this last step.
    Stuck(f64),
}

impl RodAssembly {
    /// The equilibrium that is reached from the starts.
    ///
    /// The method of multipliers (Hestenes 1969; Powell 1969; Rockafellar 1973): the energy plus
    /// one-sided springs, whose stiffness grows in a few stages, is minimised by Newton's method,
    /// and then the force of each spring becomes the force of its contact. A step in which a rod
    /// would pass through something is shortened. The second variation of the equilibrium is
    /// positive, so it is stable. Cost of a step: in proportion to the number of segments, and to
    /// the third power of the number of contacts between rods.
    ///
    /// # Errors
    /// [`StaticError::Adrift`] for a rod that nothing holds, and [`StaticError::NotConverged`].
    pub fn relax(&self, gaps: &impl GapFunctions) -> Result<AssemblyRest, StaticError> {
        let mut search = AssemblySearch::new(self, gaps);
        let mut factor = search.first_factor();
        loop {
            search.springs.factor = factor;
            let last = factor >= STIFFEST;
            let stage = search.descend(if last { TIGHT_CHANGE } else { LOOSE_CHANGE })?;
            if last {
                return search.finish(stage);
            }
            if matches!(stage, SearchStage::Rests) {
                search.take_forces();
            }
            factor = (factor * STAGE_GROWTH).min(STIFFEST);
        }
    }
}

struct AssemblySearch<'a, G> {
    of: &'a RodAssembly,
    gaps: &'a G,
    springs: GapSprings,
    now: AssemblyTrial,
    iterations: usize,
}

impl<'a, G: GapFunctions> AssemblySearch<'a, G> {
    fn new(of: &'a RodAssembly, gaps: &'a G) -> Self {
        let pulls = of.rods.iter().map(|rod| vec![Vector3::zeros(); rod.holds().len()]).collect();
        let springs = GapSprings { factor: STIFFEST, pushes: BTreeMap::new(), pulls };
        let frames = of.rods.iter().map(|rod| rod.start.frames.clone()).collect();
        let roots: Vec<_> = of.rods.iter().map(|rod| rod.start.positions[0]).collect();
        let now = AssemblyTrial::new(of, gaps, &springs, frames, &roots);
        Self { of, gaps, springs, now, iterations: 0 }
    }

    /// Stiffness of the first springs: soft, but no load may press anything deeply into another.
    fn first_factor(&self) -> f64 {
        let soft = self.of.rods.iter().map(|rod| {
            let segments = rod.chain.segments.len() as f64;
            let spread = (SOFT * segments).powi(-4);
            let load: f64 = rod.chain.forces.iter().map(Vector3::norm).sum();
            let depth = DEEP * self.gaps.thinnest();
            spread.max(load / (depth * rod.contact_unit()))
        });
        soft.fold(0.0, f64::max).min(STIFFEST)
    }

    /// Lets the forces of the springs be those that they start from.
    fn take_forces(&mut self) {
        let pushing = self.now.gaps.iter().zip(&self.now.pushes).filter(|(_, push)| **push > 0.0);
        self.springs.pushes = pushing.map(|(gap, push)| (gap.between, *push)).collect();
        self.springs.pulls.clone_from(&self.now.pulls);
    }

    /// Rounding error of a spring's force, N.
    fn rounding(&self) -> f64 {
        let far = self.now.stations.iter().flatten().map(|at| at.coords.amax()).fold(0.0, f64::max);
        let units = self.of.rods.iter().map(crate::assembly::AssemblyRod::contact_unit);
        ROUNDINGS * f64::EPSILON * far * STIFFEST * units.fold(0.0, f64::max)
    }

    /// From a minimum with springs to the equilibrium.
    ///
    /// The forces of the springs become those that they start from, again and again, until they
    /// hardly change; then Newton's method takes over. Where that does not converge, which contacts
    /// push was not yet settled.
    fn finish(mut self, first: SearchStage) -> Result<AssemblyRest, StaticError> {
        let mut stage = first;
        let mut settled = SETTLED.into_iter();
        let mut wanted = settled.next();
        for _ in 0..MOST_UPDATES {
            match stage {
                SearchStage::Rests => {}
                SearchStage::Loose(rod) => return Err(StaticError::Adrift { rod }),
                SearchStage::Stuck(step) => return Err(self.not_converged(step)),
            }
            let before = self.springs.clone();
            self.take_forces();
            let [change, largest] = self.springs.change(&before);
            if let Some(enough) = wanted
                && change <= enough * largest
            {
                if let Some(rest) = self.polished()? {
                    return Ok(rest);
                }
                wanted = settled.next();
            }
            stage = self.descend(TIGHT_CHANGE)?;
        }
        Err(self.not_converged(0.0))
    }

    /// The equilibrium by Newton's method with forces as unknowns, if it converges.
    ///
    /// Springs so stiff that their forces would be lost in rounded positions serve in each step as
    /// constraints; the forces come from the step.
    fn polished(&mut self) -> Result<Option<AssemblyRest>, StaticError> {
        let kept = (self.springs.clone(), self.now.frames.clone(), self.now.roots());
        self.springs.factor = CONSTRAINT;
        self.renew();
        for _ in 0..FEW_POLISHES {
            self.iterations += 1;
            let Some(step) = self.now.step(self.of, &self.springs, true) else { break };
            let size = self.size(&step.rods);
            if let Some(rod) = step.loose.filter(|_| step.shift > 0.0) {
                return Err(StaticError::Adrift { rod });
            }
            if size > FAR_POLISH || !size.is_finite() {
                break;
            }
            let springs = self.now.foretold(self.of, &self.springs, &step.rods);
            let [change, largest] = springs.change(&self.springs);
            let (frames, roots) = self.now.moved(&step.rods, 1.0);
            self.springs = springs;
            self.now = self.trial(frames, &roots);
            if size < TIGHT_CHANGE && change <= FORCE_CHANGE * largest + self.rounding() {
                // Soft springs add nothing to the forces that they start from.
                self.springs.factor = 1.0;
                self.renew();
                return Ok(Some(self.rest()));
            }
        }
        let (springs, frames, roots) = kept;
        self.springs = springs;
        self.now = self.trial(frames, &roots);
        Ok(None)
    }

    fn not_converged(&self, step: f64) -> StaticError {
        StaticError::NotConverged { iterations: self.iterations, step }
    }

    /// Looks at the present shape again, with the springs as they are now.
    fn renew(&mut self) {
        let (frames, roots) = (self.now.frames.clone(), self.now.roots());
        self.now = AssemblyTrial::new(self.of, self.gaps, &self.springs, frames, &roots);
    }

    /// Minimises the merit until a step is smaller than `enough`.
    fn descend(&mut self, enough: f64) -> Result<SearchStage, StaticError> {
        self.renew();
        let mut size = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            self.iterations += 1;
            let Some(step) = self.downhill() else { break };
            size = self.size(&step.rods);
            if !size.is_finite() {
                break;
            }
            if let Some(rod) = self.away() {
                return Err(StaticError::Adrift { rod });
            }
            if size < NEAR_SADDLE
                && let Some(falling) = &step.falling
                && self.fall(falling)
            {
                continue;
            }
            let whole = (LONGEST / size).min(1.0);
            if size < enough {
                // A round rod that has buckled may do so in any plane, which rounding alone tells.
                let (frames, roots) = self.now.moved(&step.rods, whole);
                self.now = self.trial(frames, &roots);
                let loose = step.loose.filter(|_| step.shift > 0.0);
                return Ok(loose.map_or(SearchStage::Rests, SearchStage::Loose));
            }
            if !self.search_line(&step.rods, step.slope, whole, size) {
                break;
            }
        }
        Ok(SearchStage::Stuck(size))
    }

    /// The Newton step of the merit, or, where its second variation is not positive but is with the
    /// forces that the springs start from, the step with these.
    fn downhill(&self) -> Option<AssemblyStep> {
        let step = self.now.step(self.of, &self.springs, false);
        if step.as_ref().is_some_and(|step| step.shift == 0.0) {
            return step;
        }
        let other = self.now.step(self.of, &self.springs, true);
        other.filter(|other| other.shift == 0.0 && other.slope < 0.0).or(step)
    }

    fn trial(&self, frames: Vec<Vec<UnitQuaternion<f64>>>, roots: &[Point3<f64>]) -> AssemblyTrial {
        AssemblyTrial::new(self.of, self.gaps, &self.springs, frames, roots)
    }

    /// Takes the longest part of a step that passes through nothing and lowers the merit enough.
    fn search_line(&mut self, step: &[RodVariation], slope: f64, whole: f64, size: f64) -> bool {
        let before = self.now.merit + MERIT_ROUNDING * self.now.merit.abs();
        let mut part = whole;
        while part >= SHORTEST_PART {
            let (frames, roots) = self.now.moved(step, part);
            let next = self.trial(frames, &roots);
            let low = before + SUFFICIENT * part * slope.min(0.0);
            if !self.gaps.is_crossed(&self.now.stations, &next.stations)
                && (size < CLOSE_STEP || next.merit <= low)
            {
                self.now = next;
                return true;
            }
            part *= 0.5;
        }
        false
    }

    /// Goes to the lowest of several shapes along a variation; false if none is lower.
    fn fall(&mut self, falling: &[RodVariation]) -> bool {
        let largest = self.size(falling);
        let mut lowest: Option<AssemblyTrial> = None;
        for size in TRIED_FALLS.into_iter().flat_map(|size| [size, -size]) {
            let (frames, roots) = self.now.moved(falling, size / largest);
            let next = self.trial(frames, &roots);
            let low = lowest.as_ref().map_or(self.now.merit, |trial| trial.merit);
            if next.merit < low - MERIT_ROUNDING * low.abs()
                && !self.gaps.is_crossed(&self.now.stations, &next.stations)
            {
                lowest = Some(next);
            }
        }
        let found = lowest.is_some();
        if let Some(lowest) = lowest {
            self.now = lowest;
        }
        found
    }

    /// The largest rotation of a node, rad, or displacement of a root, in lengths of its rod.
    fn size(&self, step: &[RodVariation]) -> f64 {
        let sizes = self.of.rods.iter().zip(step).flat_map(|(rod, step)| {
            let turns = step.turns.iter().map(Vector3::norm);
            turns.chain([step.ways.nodes[0].norm() / rod.length()])
        });
        sizes.fold(0.0, |a, b| if b.is_nan() { f64::INFINITY } else { a.max(b) })
    }

    /// A rod that is far from where it started.
    fn away(&self) -> Option<usize> {
        self.of.rods.iter().zip(&self.now.places).position(|(rod, places)| {
            rod.root == RootSupport::Free
                && (places.nodes[0] - rod.start.positions[0]).norm() > AWAY * rod.length()
        })
    }

    fn rest(&self) -> AssemblyRest {
        let now = &self.now;
        let forces = now.forces(self.of, &now.pushes, &now.pulls);
        let mut unbalanced = 0.0_f64;
        let (mut shapes, mut states) = (Vec::new(), Vec::new());
        let (mut elastic, mut load) = (Vec::new(), Vec::new());
        for (i, rod) in self.of.rods.iter().enumerate() {
            let frames = &now.frames[i];
            let loaded = LoadedRod::new(&rod.chain, rod.root, frames, &forces[i]);
            let (moments, _) = loaded.residual(&loaded.blocks());
            unbalanced = moments.iter().map(Vector3::norm).fold(unbalanced, f64::max);
            states.push(loaded.states(&now.places[i].nodes[0]));
            let shape = Shape { frames: frames.clone(), positions: now.places[i].nodes.clone() };
            elastic.push(rod.chain.elastic_energy(&shape));
            load.push(0.0 - rod.chain.work(&shape));
            shapes.push(shape);
        }
        let pushes = self.now.gaps.iter().zip(&self.now.pushes);
        let slackness = pushes.clone().map(|(gap, push)| push * gap.value.abs());
        let slackness = slackness.fold(0.0, f64::max);
        let penetration = self.now.gaps.iter().map(|gap| -gap.value).fold(0.0, f64::max);
        let largest = self.now.pushes.iter().fold(0.0, |a: f64, b| a.max(*b));
        let contacts = pushes.filter(|(_, push)| **push > FORCE_CHANGE * largest);
        AssemblyRest {
            contacts: contacts.map(|(gap, push)| (gap.clone(), *push)).collect(),
            pulls: now.pulls.clone(),
            stations: now.stations.clone(),
            shapes,
            states,
            elastic,
            load,
            penetration,
            slackness,
            unbalanced,
            iterations: self.iterations,
        }
    }
}
