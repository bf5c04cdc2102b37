//! Newton steps of an assembly.

use crate::assembly::RodAssembly;
use crate::assembly_trial::{AssemblyTrial, GapSprings};
use crate::loaded_rod::LoadedRod;
use crate::riccati::{OnRod, RiccatiFactor, RodVariation, SecondVariation};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// Multiples of the blocks' shifts that are tried in turn.
const SHIFTS: [f64; 6] = [0.0, 0.1, 1.0, 4.0, 16.0, 64.0];
/// Part of the largest eigenvalue of a gap's curvature below which one counts as zero.
const FLAT: f64 = 1e-9;

/// A Newton step of an assembly.
pub(crate) struct AssemblyStep {
    pub(crate) rods: Vec<RodVariation>,
    /// Multiple of the shifts that makes the second variation positive.
    pub(crate) shift: f64,
    /// A rod whose root has a freedom that nothing holds.
    pub(crate) loose: Option<usize>,
    /// A variation along which the energy falls.
    pub(crate) falling: Option<Vec<RodVariation>>,
    /// Change of the energy along the step, to first order, J.
    pub(crate) slope: f64,
}

/// What acts on a rod: moments on its nodes, N m, in their own axes, and forces, N.
type RodLoads = (Vec<Vector3<f64>>, OnRod<Vector3<f64>>);

/// A stiffness along one direction of several stations: what couples rods.
struct StationLink {
    rows: Vec<(usize, usize, Vector3<f64>)>,
    stiffness: f64,
}

impl StationLink {
    /// The way along the direction when each station moves by what `of` says.
    fn along(&self, of: impl Fn(usize, usize) -> Vector3<f64>) -> f64 {
        self.rows.iter().map(|(rod, station, row)| row.dot(&of(*rod, *station))).sum()
    }
}

impl AssemblyTrial {
    /// The Newton step from here; `None` if all matrices are singular. If the springs serve as
    /// `constraints`, the rods are stressed by the forces that the springs start from.
    pub(crate) fn step(
        &self,
        of: &RodAssembly,
        springs: &GapSprings,
        constraints: bool,
    ) -> Option<AssemblyStep> {
        let stressing: Vec<f64> = if constraints {
            let pushing = self.gaps.iter().zip(&self.pushes).map(|(gap, push)| {
                springs.pushes.get(&gap.between).copied().filter(|_| *push > 0.0)
            });
            pushing.map(Option::unwrap_or_default).collect()
        } else {
            self.pushes.clone()
        };
        let pulls = if constraints { &springs.pulls } else { &self.pulls };
        let forces = self.forces(of, &stressing, pulls);
        // What the springs do beyond.
        let excess: Vec<f64> = self.pushes.iter().zip(&stressing).map(|(a, b)| a - b).collect();
        let more = self
            .pulls
            .iter()
            .zip(pulls)
            .map(|(all, own)| all.iter().zip(own).map(|(all, own)| all - own).collect());
        let excess = self.forces(of, &excess, &more.collect::<Vec<Vec<_>>>());
        let mut parts = Vec::with_capacity(of.rods.len());
        let mut loads = Vec::with_capacity(of.rods.len());
        for (i, (rod, mut excess)) in of.rods.iter().zip(excess).enumerate() {
            let loaded = LoadedRod::new(&rod.chain, rod.root, &self.frames[i], &forces[i]);
            let blocks = loaded.blocks();
            let (moments, force) = loaded.residual(&blocks);
            excess.nodes[0] += force;
            parts.push((blocks, loaded.motions()));
            loads.push((moments, excess));
        }
        let (mut falling, mut loose) = (None, None);
        for shift in SHIFTS {
            let stiffnesses = self.springs(of, springs, &stressing, shift == 0.0);
            let mut factors = Vec::with_capacity(parts.len());
            for ((rod, (blocks, [motions, halves])), springs) in
                of.rods.iter().zip(&parts).zip(stiffnesses)
            {
                let (units, tip, root) = (rod.units(), rod.chain.tip, rod.root);
                let system =
                    SecondVariation { blocks, motions, halves, springs, shift, units, tip, root };
                factors.push(RiccatiFactor::of(&system)?);
            }
            let links = self.links(of, springs, &stressing, shift == 0.0);
            let (rods, negative) = linked(&factors, &links, &loads)?;
            if negative > 0 {
                if shift == 0.0 {
                    loose = factors.iter().position(|factor| factor.loose);
                    falling = self.falling(&factors);
                }
                continue;
            }
            let slope = rods.iter().zip(&loads).map(|(step, (moments, forces))| {
                let turned = step.turns.iter().zip(moments).map(|(turn, moment)| turn.dot(moment));
                let nodes = step.ways.nodes.iter().zip(&forces.nodes);
                let all = nodes.chain(step.ways.middles.iter().zip(&forces.middles));
                turned.sum::<f64>() + all.map(|(way, force)| way.dot(force)).sum::<f64>()
            });
            return Some(AssemblyStep { slope: -slope.sum::<f64>(), rods, shift, loose, falling });
        }
        None
    }

    /// A variation of one rod along which the energy falls.
    fn falling(&self, factors: &[RiccatiFactor]) -> Option<Vec<RodVariation>> {
        let (at, falling) =
            factors.iter().enumerate().find_map(|(i, factor)| Some((i, factor.falling()?)))?;
        let still = self.frames.iter().map(|frames| RodVariation {
            turns: vec![Vector3::zeros(); frames.len()],
            ways: OnRod::filled(&Vector3::zeros(), frames.len() - 1),
        });
        let mut all: Vec<_> = still.collect();
        all[at] = falling;
        Some(all)
    }

    /// Stiffnesses of nodes and middles by contacts of single stations, `curved` with the curvature
    /// of the gaps, and by held places.
    fn springs(
        &self,
        of: &RodAssembly,
        springs: &GapSprings,
        stressing: &[f64],
        curved: bool,
    ) -> Vec<OnRod<Matrix3<f64>>> {
        let segments = self.places.iter().map(|places| places.middles.len());
        let mut all: Vec<_> =
            segments.map(|segments| OnRod::filled(&Matrix3::zeros(), segments)).collect();
        for (own, rod) in all.iter_mut().zip(&of.rods) {
            for target in rod.holds() {
                let stiffness = springs.factor * rod.contact_unit();
                own.nodes[target.node] += Matrix3::from_diagonal_element(stiffness);
            }
        }
        for ((gap, push), stress) in self.gaps.iter().zip(&self.pushes).zip(stressing) {
            let [term] = gap.terms[..] else { continue };
            if *push == 0.0 {
                continue;
            }
            let stiffness = of.stiffness(springs, gap);
            let spring = all[term.rod].at_mut(term.station);
            *spring += term.derivative * term.derivative.transpose() * stiffness;
            if curved {
                *spring -= gap.curvature.fixed_view::<3, 3>(0, 0) * *stress;
            }
        }
        all
    }

    /// The stiffnesses of contacts of several stations.
    fn links(
        &self,
        of: &RodAssembly,
        springs: &GapSprings,
        stressing: &[f64],
        curved: bool,
    ) -> Vec<StationLink> {
        let mut links = Vec::new();
        for ((gap, push), stress) in self.gaps.iter().zip(&self.pushes).zip(stressing) {
            if *push == 0.0 || gap.terms.len() == 1 {
                continue;
            }
            let rows = gap.terms.iter().map(|term| (term.rod, term.station, term.derivative));
            links.push(StationLink { rows: rows.collect(), stiffness: of.stiffness(springs, gap) });
            if !curved || *stress == 0.0 {
                continue;
            }
            let eigen = gap.curvature.clone().symmetric_eigen();
            let largest = eigen.eigenvalues.amax();
            for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
                if value.abs() <= FLAT * largest {
                    continue;
                }
                let rows = gap.terms.iter().enumerate().map(|(i, term)| {
                    (term.rod, term.station, vector.fixed_rows::<3>(3 * i).into_owned())
                });
                links.push(StationLink { rows: rows.collect(), stiffness: -value * stress });
            }
        }
        links
    }
}

/// The variation under loads on rods that are linked, by the Schur complement of the forces of the
/// links, and the number of variations that lower the energy.
fn linked(
    factors: &[RiccatiFactor],
    links: &[StationLink],
    loads: &[RodLoads],
) -> Option<(Vec<RodVariation>, usize)> {
    let negative: usize = factors.iter().map(|factor| factor.negative).sum();
    let alone = factors.iter().zip(loads);
    let mut step: Vec<RodVariation> =
        alone.map(|(factor, (moments, forces))| factor.solve(moments, forces)).collect();
    if links.is_empty() {
        return Some((step, negative));
    }
    // Responses of the rods to the links, by link: pairs of rod and variation.
    let response = |link: &StationLink| -> Vec<(usize, RodVariation)> {
        let mut rods: Vec<usize> = link.rows.iter().map(|row| row.0).collect();
        rods.dedup();
        let on = |rod: usize| {
            let nodes = loads[rod].0.len();
            let mut forces = OnRod::filled(&Vector3::zeros(), nodes - 1);
            for (_, station, row) in link.rows.iter().filter(|row| row.0 == rod) {
                *forces.at_mut(*station) += row;
            }
            (rod, factors[rod].solve(&vec![Vector3::zeros(); nodes], &forces))
        };
        rods.into_iter().map(on).collect()
    };
    let responses: Vec<_> = links.iter().map(response).collect();
    let compliance = DMatrix::from_fn(links.len(), links.len(), |i, j| {
        let moved = links[i].along(|rod, station| {
            let own = responses[j].iter().find(|one| one.0 == rod);
            own.map_or_else(Vector3::zeros, |one| *one.1.ways.at(station))
        });
        moved + if i == j { links[i].stiffness.recip() } else { 0.0 }
    });
    let compliance = 0.5 * (&compliance + compliance.transpose());
    let off = links.iter().map(|link| link.along(|rod, at| *step[rod].ways.at(at)));
    let off = DVector::from_iterator(links.len(), off);
    let forces = compliance.clone().lu().solve(&off)?;
    for (own, force) in responses.iter().zip(forces.iter()) {
        for (rod, response) in own {
            let to = &mut step[*rod];
            let pairs = to.turns.iter_mut().zip(&response.turns);
            let nodes = to.ways.nodes.iter_mut().zip(&response.ways.nodes);
            let middles = to.ways.middles.iter_mut().zip(&response.ways.middles);
            pairs.chain(nodes).chain(middles).for_each(|(to, by)| *to -= by * *force);
        }
    }
    // Sylvester's law of inertia for the matrix of rods and links.
    let own = links.iter().filter(|link| link.stiffness < 0.0).count();
    let all = compliance.symmetric_eigenvalues().iter().filter(|e| **e < 0.0).count();
    Some((step, (negative + own).saturating_sub(all)))
}
