//! Energy and nodal forces of charged fibres.

use super::lines::SegmentLines;
use super::solver::{Beside, SegmentSolution, loads};
use crate::error::{check_charges, check_count, check_positions, check_positive};
use crate::multipole::accuracy::check_accuracy;
use crate::multipole::solver::unit;
use crate::multipole::tree::Octree;
use crate::{
    Accuracy, COULOMB_CONSTANT, Certificate, Condition, ConductingSurface, ElectrostaticsError,
};
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::Layout;
use rayon::prelude::*;

/// Number of segments in a leaf, from measured rates.
const SEGMENTS_PER_LEAF: usize = 64;

/// Charged fibres: the straight segments between their nodes, each with its charge spread evenly.
///
/// A segment acts on itself and on its neighbors by the kernel `1/sqrt(r^2 + a^2)` with the radius
/// a of the fibre; for a ring this gives the self-force `lambda^2/R (ln(8R/a) - 1)` of a charged
/// torus, if segments are longer than ten radii. All others act as lines, which for round fibres
/// that do not overlap is exact.
#[derive(Debug, Clone)]
pub struct ChargedFibers<'a> {
    /// Numbering of nodes and segments.
    pub layout: &'a Layout,
    /// Charge of each segment, C; a charge density that varies along a fibre is constant in a
    /// segment.
    pub charges: &'a [f64],
    /// Radius of each fibre, m.
    pub radii: &'a [f64],
    /// Required accuracy of the nodal forces: the root of the sum of their squared errors over that
    /// of their squares.
    pub accuracy: Accuracy,
}

/// Energy and forces of charged fibres.
#[derive(Debug, Clone, PartialEq)]
pub struct Electrostatics {
    /// Energy of the fibres, with their own, J.
    pub energy: f64,
    /// Forces on the nodes (world), N: the negative gradient of the energy, each segment keeping
    /// its charge.
    pub forces: Vec<Vector3<f64>>,
    /// Error of the forces at sampled segments.
    pub certificate: Certificate,
}

impl ChargedFibers<'_> {
    /// Energy and forces with the nodes at `positions` (world, m).
    ///
    /// Close pairs are integrated in closed form, all others by points of a rule on both. A segment
    /// may see another by a better rule than that sees it, so forces are the gradient of the
    /// energy, and there is no net force or moment, to the tolerance. Cost: see the README.
    ///
    /// # Errors
    /// Arrays that do not fit, positions or charges that are not finite, radii that are not
    /// positive, segments without length, and an accuracy out of range or reach.
    pub fn forces(&self, positions: &[Point3<f64>]) -> Result<Electrostatics, ElectrostaticsError> {
        self.solve(positions, None)
    }

    /// Energy and forces with the nodes at `positions` (world, m) beside a conductor, which is
    /// drawn to the fibres and draws them: its charges are those that their potentials induce, to
    /// the degree of expansions that the forces of fibres on each other need. Both these and its
    /// forces on them are exact to the tolerance of themselves, as far as triangles are. The energy
    /// is without the conductor's own at its charge, or with its potential without the work of what
    /// holds that.
    ///
    /// # Errors
    /// Errors of [`forces`](Self::forces), [`ElectrostaticsError::Inside`] with the index of a
    /// segment that is in the conductor, and no convergence.
    pub fn forces_beside(
        &self,
        positions: &[Point3<f64>],
        surface: &ConductingSurface,
        condition: Condition,
    ) -> Result<Electrostatics, ElectrostaticsError> {
        self.solve(positions, Some((surface, condition)))
    }

    /// Energy and forces, with a conductor and its condition if there is one.
    fn solve(
        &self,
        positions: &[Point3<f64>],
        beside: Option<(&ConductingSurface, Condition)>,
    ) -> Result<Electrostatics, ElectrostaticsError> {
        self.check(positions)?;
        let ends = |segment| self.layout.segment_nodes(segment).map(|node| positions[node]);
        let count = self.layout.segments();
        let unit = unit(self.charges);
        let tree = Octree::new(count, SEGMENTS_PER_LEAF, ends);
        let lines = self.lines(&tree, unit, ends);
        let beside = beside.map(|(surface, condition)| Beside { surface, condition, unit });
        let SegmentSolution { loads, energy, certificate } =
            loads(&tree, &lines, beside, self.accuracy)?;
        let factor = COULOMB_CONSTANT * unit * unit;
        let places = tree.places();
        let forces = |fiber: usize| {
            let mut forces = vec![Vector3::zeros(); self.layout.node_range(fiber).len()];
            for (a, segment) in self.layout.segment_range(fiber).enumerate() {
                let [_, start @ .., bx, by, bz] = loads[places[segment] as usize];
                forces[a] += factor * Vector3::from(start);
                forces[a + 1] += factor * Vector3::new(bx, by, bz);
            }
            forces
        };
        Ok(Electrostatics {
            energy: energy + factor * loads.iter().map(|load| load[0]).sum::<f64>(),
            forces: (0..self.layout.fibers()).into_par_iter().flat_map_iter(forces).collect(),
            certificate,
        })
    }

    /// Segments in the order of `tree`, with charges in units of `unit` (C).
    fn lines(
        &self,
        tree: &Octree,
        unit: f64,
        ends: impl Fn(usize) -> [Point3<f64>; 2] + Sync,
    ) -> SegmentLines {
        let order = || tree.order.par_iter().map(|i| *i as usize);
        let fiber = |segment: usize| self.layout.segment_fibers()[segment];
        SegmentLines::new(
            order().map(&ends).collect(),
            order().map(|i| self.charges[i] / unit).collect(),
            order().map(|i| self.radii[fiber(i)].powi(2)).collect(),
            order().map(|i| ((fiber(i) as u64) << 32) | i as u64).collect(),
        )
    }

    /// Second derivative of the energy in the direction `v` (m, one vector a node), N: the central
    /// difference of the forces over a step of 1e-5 of the mean segment at the largest `v`.
    ///
    /// Relative error about 1e-6 if the tolerance is 1e-9 or less. Cost: two calls of
    /// [`forces`](Self::forces).
    ///
    /// # Errors
    /// Errors of [`forces`](Self::forces), and a direction that does not have one vector a node.
    pub fn hessian_product(
        &self,
        positions: &[Point3<f64>],
        v: &[Vector3<f64>],
    ) -> Result<Vec<Vector3<f64>>, ElectrostaticsError> {
        self.check(positions)?;
        check_count("vectors of the direction", v.len(), positions.len())?;
        let largest = v.iter().map(Vector3::norm).fold(0.0, f64::max);
        if largest == 0.0 {
            return Ok(vec![Vector3::zeros(); v.len()]);
        }
        let length = |segment: usize| {
            let [a, b] = self.layout.segment_nodes(segment);
            (positions[b] - positions[a]).norm()
        };
        let mean =
            (0..self.layout.segments()).map(length).sum::<f64>() / self.layout.segments() as f64;
        let step = 1e-5 * mean / largest;
        let moved = |step: f64| -> Result<_, ElectrostaticsError> {
            let moved: Vec<_> = positions.iter().zip(v).map(|(x, v)| x + step * v).collect();
            Ok(self.forces(&moved)?.forces)
        };
        let (ahead, behind) = (moved(step)?, moved(-step)?);
        Ok(ahead.iter().zip(&behind).map(|(a, b)| (b - a) / (2.0 * step)).collect())
    }

    /// Refuses arrays that do not fit and values out of their range.
    fn check(&self, positions: &[Point3<f64>]) -> Result<(), ElectrostaticsError> {
        check_accuracy(self.accuracy)?;
        check_count("positions", positions.len(), self.layout.nodes())?;
        check_count("radii", self.radii.len(), self.layout.fibers())?;
        check_positions("node", positions)?;
        check_charges(self.charges, self.layout.segments())?;
        self.radii.iter().try_for_each(|&radius| check_positive("a radius", radius))?;
        for segment in 0..self.layout.segments() {
            let [a, b] = self.layout.segment_nodes(segment);
            if positions[a] == positions[b] {
                let (what, range) = ("the length of a segment", "positive");
                return Err(ElectrostaticsError::Setting { what, value: 0.0, range });
            }
        }
        Ok(())
    }
}
