//! A conductor of any shape, by boundary elements.

use super::Condition;
use super::elements::Elements;
use super::iteration::{MOST_ITERATIONS, solve};
use super::outside::{Add, ExteriorBodies};
use crate::direct_sum::{Cloud, places};
use crate::error::{check_charges, check_count, check_positions};
use crate::harmonics::Coefficient;
use crate::multipole::accuracy::check_accuracy;
use crate::multipole::solver::unit;
use crate::multipole::tree::Octree;
use crate::multipole::upward::{Multipoles, scaled};
use crate::{Accuracy, COULOMB_CONSTANT, ElectrostaticsError, Fields};
use nalgebra::Point3;
use rapunzel_collision::field::{DistanceField, Grid, Mesh};
use rayon::prelude::*;

/// Relative residual to which the charges are found.
const RESIDUAL: f64 = 1e-6;

/// Number of nodes of the distance field along the longest side of the mesh.
const NODES: f64 = 64.0;

/// Number of points in a leaf, where they are by themselves.
const POINTS_PER_LEAF: usize = 100;

/// A conductor whose surface is a mesh.
///
/// The charge density is constant on each triangle, and the potential is right at their centers. A
/// triangle acts on other charges and feels them by seven points within the multipole method, where
/// they are close by exact integrals; on other triangles further than three of its sides away it
/// acts as one point. The error falls as the square of the triangles' size where the surface is
/// smooth. A charge must be seen by more than one triangle for its image to be right: closer to the
/// surface than a triangle is large it is drawn too weakly.
///
/// Cost: for each solution some tens of calls of the multipole method; no limit on triangles. A
/// mesh that is open or inside out is refused by [`Mesh::new`].
#[derive(Debug)]
pub struct ConductingSurface {
    /// Triangles and what they do to each other.
    elements: Elements,
    /// Signed distance from the surface.
    distance: Grid,
    /// Charges of the triangles at a potential of 1 V, C.
    unit: Vec<f64>,
}

impl ConductingSurface {
    /// Conductor with the closed surface `mesh`.
    ///
    /// # Errors
    /// A mesh that cannot be scanned for its inside, or for which the iteration does not
    /// converge.
    pub fn new(mesh: &Mesh) -> Result<Self, ElectrostaticsError> {
        let [low, high] = mesh.bounds();
        let spacing = (high - low).max() / NODES;
        let distance =
            Grid::scan(mesh, spacing, 3.0 * spacing).map_err(ElectrostaticsError::Mesh)?;
        let elements = Elements::new(mesh)?;
        let unit = charges(&elements, &vec![1.0; mesh.triangles().len()])?;
        Ok(Self { elements, distance, unit })
    }

    /// Centers of the triangles (world), m.
    #[must_use]
    pub fn centers(&self) -> &[Point3<f64>] {
        self.elements.centers()
    }

    /// Capacity of the conductor, F.
    #[must_use]
    pub fn capacity(&self) -> f64 {
        self.unit.iter().sum()
    }

    /// Charges of the triangles at a potential of 1 V without any other charge, C.
    #[must_use]
    pub fn unit_charges(&self) -> &[f64] {
        &self.unit
    }

    /// Refuses points (world, m) that are inside, by more than the error of a distance field of 64
    /// nodes along the mesh.
    ///
    /// # Errors
    /// [`ElectrostaticsError::Inside`] with the first of them.
    pub fn check_outside(&self, points: &[Point3<f64>]) -> Result<(), ElectrostaticsError> {
        check_positions("point", points)?;
        for (index, point) in points.iter().enumerate() {
            let depth = -self.distance.value(point);
            if depth > self.distance.error() {
                return Err(ElectrostaticsError::Inside { index, depth });
            }
        }
        Ok(())
    }

    /// Potentials (V) that `charges` (C) at `sources` (world, m) make at the triangles: means over
    /// those that are close, else at their centers, by the multipole method of this accuracy.
    ///
    /// # Errors
    /// Sources that are inside or not finite, and charges that do not fit.
    pub fn potentials(
        &self,
        sources: &[Point3<f64>],
        charges: &[f64],
        accuracy: Accuracy,
    ) -> Result<Vec<f64>, ElectrostaticsError> {
        check_accuracy(accuracy)?;
        self.check_outside(sources)?;
        check_charges(charges, sources.len())?;
        let unit = unit(charges);
        let (tree, cloud) = sorted(sources, |i| charges[i] / unit);
        let outside = ExteriorBodies { tree: &tree, cloud: &cloud, per_body: 1 };
        Ok(self.potentials_of(&self.elements.felt::<f64>(outside, None, accuracy)?, unit))
    }

    /// Potentials from what the triangles feel of charges in units of `unit`.
    fn potentials_of(&self, felt: &[[f64; 4]], unit: f64) -> Vec<f64> {
        let mut potentials = vec![0.0; felt.len()];
        for (&triangle, felt) in self.elements.tree.order.iter().zip(felt) {
            potentials[triangle as usize] = COULOMB_CONSTANT * unit * felt[0];
        }
        potentials
    }

    /// Charges of the triangles (C) when the other charges make `potentials` (V) at them.
    ///
    /// # Errors
    /// Potentials that are not finite or not one for each triangle, and no convergence.
    pub fn charges(
        &self,
        potentials: &[f64],
        condition: Condition,
    ) -> Result<Vec<f64>, ElectrostaticsError> {
        check_count("potentials", potentials.len(), self.unit.len())?;
        check_charges(potentials, self.unit.len())?;
        Ok(self.respond(potentials, condition)?.0)
    }

    /// Charges of the triangles (C), and the energy of the conductor (J) beside half of that of the
    /// other charges in the potential that it makes: with a given potential less the work of what
    /// holds it, and without that of its own charge.
    fn respond(
        &self,
        potentials: &[f64],
        condition: Condition,
    ) -> Result<(Vec<f64>, f64), ElectrostaticsError> {
        // Linear superposition: the charges that cancel the potentials of the others, and those of
        // a constant potential, which meets the condition.
        let induced = charges(&self.elements, potentials)?;
        let drawn = induced.iter().sum::<f64>();
        let (potential, own) = match condition {
            Condition::Potential(potential) => (potential, potential),
            Condition::Charge(charge) => {
                ((charge + drawn) / self.capacity(), charge / self.capacity())
            }
        };
        let charges = self.unit.iter().zip(&induced).map(|(unit, q)| unit * potential - q);
        Ok((charges.collect(), 0.5 * own * drawn))
    }

    /// Adds to `out` the action of this conductor on bodies outside, as [`Elements::make`] does,
    /// where their charges (in units of `unit`, C) have these multipoles and degree `known`.
    /// Returns the energy of the conductor (J), as [`respond`](Self::respond) tells it, and the
    /// relative error.
    pub(crate) fn act<E: Coefficient, const N: usize>(
        &self,
        condition: Condition,
        (outside, unit): (ExteriorBodies, f64),
        known: (&Multipoles<E>, usize),
        accuracy: Accuracy,
        add: Add<N>,
        out: &mut [[f64; N]],
    ) -> Result<[f64; 2], ElectrostaticsError> {
        let felt = self.elements.felt(outside, Some(known), accuracy)?;
        let (charges, energy) = self.respond(&self.potentials_of(&felt, unit), condition)?;
        let charges: Vec<_> = charges.iter().map(|charge| charge / unit).collect();
        Ok([energy, self.elements.make(&charges, outside, accuracy, add, out)?])
    }

    /// Refuses bodies of which a point is inside, as [`check_outside`](Self::check_outside) does
    /// points.
    pub(crate) fn check_bodies(&self, outside: ExteriorBodies) -> Result<(), ElectrostaticsError> {
        let ExteriorBodies { tree, cloud, per_body } = outside;
        for cell in tree.cells.iter().filter(|cell| cell.is_leaf()) {
            let reach = self.distance.lipschitz() * cell.radius;
            if self.distance.value(&cell.center) > reach {
                continue;
            }
            for k in scaled(&cell.bodies, per_body) {
                let depth = -self.distance.value(&[0, 1, 2].map(|d| cloud.x[d][k]).into());
                if depth > self.distance.error() {
                    let index = tree.order[k / per_body] as usize;
                    return Err(ElectrostaticsError::Inside { index, depth });
                }
            }
        }
        Ok(())
    }

    /// Potentials and fields that triangles with the `charges` of a solution (C) make at `targets`
    /// (world, m) outside, by the multipole method of this accuracy; the forces on charges there
    /// are the gradient of their energy in the [`potentials`](Self::potentials) that they make.
    ///
    /// # Errors
    /// Targets that are inside or not finite, and charges that do not fit.
    pub fn fields(
        &self,
        charges: &[f64],
        targets: &[Point3<f64>],
        accuracy: Accuracy,
    ) -> Result<Fields, ElectrostaticsError> {
        check_accuracy(accuracy)?;
        check_charges(charges, self.unit.len())?;
        self.check_outside(targets)?;
        let unit = unit(charges);
        let charges: Vec<_> = charges.iter().map(|charge| charge / unit).collect();
        let (tree, cloud) = sorted(targets, |_| 0.0);
        let outside = ExteriorBodies { tree: &tree, cloud: &cloud, per_body: 1 };
        let add = |_: usize, sums: &[[f64; 4]], out: &mut [f64; 4]| {
            out.iter_mut().zip(&sums[0]).for_each(|(out, sum)| *out += sum);
        };
        let mut sums = vec![[0.0; 4]; targets.len()];
        self.elements.make(&charges, outside, accuracy, &add, &mut sums)?;
        let place = tree.places();
        Ok(Fields::new(unit, sums.len(), |i| sums[place[i] as usize]))
    }
}

/// Tree over `points` (world, m), and the points with their charges in its order.
fn sorted(points: &[Point3<f64>], charge: impl Fn(usize) -> f64 + Sync + Send) -> (Octree, Cloud) {
    let tree = Octree::new(points.len(), POINTS_PER_LEAF, |i| [points[i]]);
    let order = tree.order.par_iter().map(|&i| i as usize);
    let charge = order.clone().map(charge).collect();
    let cloud = Cloud::new(places(order.map(|i| points[i])), charge);
    (tree, cloud)
}

/// Charges (C) of the triangles that make `potentials` (V) at them.
fn charges(elements: &Elements, potentials: &[f64]) -> Result<Vec<f64>, ElectrostaticsError> {
    let apply = |charges: &[f64]| elements.apply(charges);
    let (charges, residual) = solve(apply, elements.diagonal(), potentials, RESIDUAL)?;
    if residual > RESIDUAL {
        return Err(ElectrostaticsError::NoConvergence { iterations: MOST_ITERATIONS, residual });
    }
    Ok(charges)
}
