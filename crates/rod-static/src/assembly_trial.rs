//! Shapes of an assembly that a search tries.

use crate::assembly::RodAssembly;
use crate::gap::{Gap, GapFunctions};
use crate::loaded_rod::{LoadedRod, places};
use crate::riccati::{OnRod, RodVariation};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use std::collections::BTreeMap;

/// Stiffness of the springs in the gaps, and the forces that they start from.
#[derive(Debug, Clone)]
pub(crate) struct GapSprings {
    /// In units of the stiffness of a segment.
    pub(crate) factor: f64,
    /// Forces of contacts, N, by what they are between.
    pub(crate) pushes: BTreeMap<[usize; 4], f64>,
    /// Forces of held places, N, by rod.
    pub(crate) pulls: Vec<Vec<Vector3<f64>>>,
}

/// A shape of an assembly.
pub(crate) struct AssemblyTrial {
    pub(crate) frames: Vec<Vec<UnitQuaternion<f64>>>,
    pub(crate) places: Vec<OnRod<Point3<f64>>>,
    /// Positions of the stations, m, by rod.
    pub(crate) stations: Vec<Vec<Point3<f64>>>,
    pub(crate) gaps: Vec<Gap>,
    /// Forces in the gaps, N.
    pub(crate) pushes: Vec<f64>,
    /// Forces of held places, N, world frame, by rod.
    pub(crate) pulls: Vec<Vec<Vector3<f64>>>,
    /// Energy of the rods, their loads and the springs, J.
    pub(crate) merit: f64,
}

impl GapSprings {
    /// The largest difference of a force from what it was before, N, and the largest force.
    pub(crate) fn change(&self, before: &Self) -> [f64; 2] {
        let [mut change, mut largest] = [0.0_f64; 2];
        for between in self.pushes.keys().chain(before.pushes.keys()) {
            let [now, old] =
                [self, before].map(|one| one.pushes.get(between).copied().unwrap_or(0.0));
            change = change.max((now - old).abs());
            largest = largest.max(now);
        }
        for (now, old) in self.pulls.iter().flatten().zip(before.pulls.iter().flatten()) {
            change = change.max((now - old).norm());
            largest = largest.max(now.norm());
        }
        [change, largest]
    }
}

impl AssemblyTrial {
    pub(crate) fn new(
        of: &RodAssembly,
        gaps: &impl GapFunctions,
        springs: &GapSprings,
        frames: Vec<Vec<UnitQuaternion<f64>>>,
        roots: &[Point3<f64>],
    ) -> Self {
        let mut merit = 0.0;
        let mut all = Vec::with_capacity(frames.len());
        let mut pulls = Vec::with_capacity(frames.len());
        for (i, (rod, own)) in of.rods.iter().zip(&frames).enumerate() {
            let at = places(&rod.chain, own, &roots[i]);
            merit += LoadedRod::energy(&rod.chain, own, &at);
            let stiffness = springs.factor * rod.contact_unit();
            let mut held = Vec::with_capacity(rod.holds().len());
            for (target, pull) in rod.holds().iter().zip(&springs.pulls[i]) {
                let off = at.nodes[target.node] - target.place;
                merit += 0.5 * stiffness * off.norm_squared() - pull.dot(&off);
                held.push(pull - stiffness * off);
            }
            pulls.push(held);
            all.push(at);
        }
        let stations: Vec<Vec<Point3<f64>>> = all.iter().map(OnRod::stations).collect();
        let gaps = gaps.gaps(&stations);
        let mut pushes = Vec::with_capacity(gaps.len());
        for gap in &gaps {
            let stiffness = of.stiffness(springs, gap);
            let before = springs.pushes.get(&gap.between).copied().unwrap_or(0.0);
            let push = (before - stiffness * gap.value).max(0.0);
            merit += 0.5 * push * push / stiffness;
            pushes.push(push);
        }
        Self { frames, places: all, stations, gaps, pushes, pulls, merit }
    }

    pub(crate) fn roots(&self) -> Vec<Point3<f64>> {
        self.places.iter().map(|places| places.nodes[0]).collect()
    }

    /// The frames and roots after a part of a step.
    pub(crate) fn moved(
        &self,
        step: &[RodVariation],
        part: f64,
    ) -> (Vec<Vec<UnitQuaternion<f64>>>, Vec<Point3<f64>>) {
        let turned = self.frames.iter().zip(step).map(|(frames, step)| {
            let turn = |(frame, turn): (&UnitQuaternion<f64>, &Vector3<f64>)| {
                let turned = *frame * UnitQuaternion::from_scaled_axis(turn * part);
                UnitQuaternion::new_normalize(turned.into_inner())
            };
            frames.iter().zip(&step.turns).map(turn).collect()
        });
        let roots = self.places.iter().zip(step);
        let roots = roots.map(|(places, step)| places.nodes[0] + step.ways.nodes[0] * part);
        (turned.collect(), roots.collect())
    }

    /// Forces of contacts and of held places, N, world frame, by rod.
    pub(crate) fn forces(
        &self,
        of: &RodAssembly,
        pushes: &[f64],
        pulls: &[Vec<Vector3<f64>>],
    ) -> Vec<OnRod<Vector3<f64>>> {
        let segments = self.places.iter().map(|places| places.middles.len());
        let mut forces: Vec<_> =
            segments.map(|segments| OnRod::filled(&Vector3::zeros(), segments)).collect();
        for (forces, (rod, pulls)) in forces.iter_mut().zip(of.rods.iter().zip(pulls)) {
            for (target, pull) in rod.holds().iter().zip(pulls) {
                forces.nodes[target.node] += pull;
            }
        }
        for (gap, push) in self.gaps.iter().zip(pushes) {
            for term in &gap.terms {
                *forces[term.rod].at_mut(term.station) += term.derivative * *push;
            }
        }
        forces
    }

    /// The forces after a step, by the linear equations of the step.
    pub(crate) fn foretold(
        &self,
        of: &RodAssembly,
        springs: &GapSprings,
        step: &[RodVariation],
    ) -> GapSprings {
        let mut pushes = BTreeMap::new();
        for (gap, push) in self.gaps.iter().zip(&self.pushes).filter(|(_, push)| **push > 0.0) {
            let change = gap
                .terms
                .iter()
                .map(|term| term.derivative.dot(step[term.rod].ways.at(term.station)));
            let push = push - of.stiffness(springs, gap) * change.sum::<f64>();
            if push > 0.0 {
                pushes.insert(gap.between, push);
            }
        }
        let mut pulls = self.pulls.clone();
        for (i, (rod, pulls)) in of.rods.iter().zip(&mut pulls).enumerate() {
            let stiffness = springs.factor * rod.contact_unit();
            for (target, pull) in rod.holds().iter().zip(pulls) {
                *pull -= stiffness * step[i].ways.nodes[target.node];
            }
        }
        GapSprings { pushes, pulls, ..*springs }
    }
}

impl RodAssembly {
    /// Stiffness of the spring in a gap, N/m.
    pub(crate) fn stiffness(&self, springs: &GapSprings, gap: &Gap) -> f64 {
        let units = gap.terms.iter().map(|term| self.rods[term.rod].contact_unit());
        springs.factor * units.fold(f64::INFINITY, f64::min)
    }
}
