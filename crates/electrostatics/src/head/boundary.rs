//! A conductor of any shape, by boundary elements.

use super::Condition;
use super::elements::Elements;
use super::iteration::{MOST, solve};
use crate::error::{check_charges, check_count, check_positions};
use crate::{Accuracy, ElectrostaticsError, Fields};
use nalgebra::Point3;
use rapunzel_collision::field::{DistanceField, Grid, Mesh};

/// Relative residual to which charges are found.
const RESIDUAL: f64 = 1e-6;

/// Nodes of the distance field along the longest side of the mesh.
const NODES: f64 = 64.0;

/// A conductor whose surface is a mesh.
///
/// The charge density is constant on each triangle, and the potential is right at their centers. A
/// triangle acts on other charges and feels them by seven points within the multipole method, where they
/// are close by exact integrals; on other triangles further than three of its sides away it acts as one
/// point. The error falls as the square of the triangles' size where the surface is smooth. A charge must
/// be seen by more than one triangle for its image to be right: closer to the surface than a triangle is
/// large it is drawn too weakly.
///
/// Cost: for each solution some tens of calls of the multipole method; no limit on triangles. A mesh
/// that is open or inside out is refused by [`Mesh::new`].
#[derive(Debug)]
pub struct ConductingSurface {
    elements: Elements,
    distance: Grid,
    /// Charges of the triangles at a potential of 1 V, C.
    unit: Vec<f64>,
}

impl ConductingSurface {
    /// A closed surface.
    ///
    /// # Errors
    /// A mesh that cannot be scanned for its inside, or for which the iteration does not converge.
    pub fn new(mesh: &Mesh) -> Result<Self, ElectrostaticsError> {
        let [low, high] = mesh.bounds();
        let spacing = (high - low).max() / NODES;
        let distance =
            Grid::scan(mesh, spacing, 3.0 * spacing).map_err(ElectrostaticsError::Mesh)?;
        let elements = Elements::new(mesh)?;
        let unit = charges(&elements, &vec![1.0; mesh.triangles().len()])?;
        Ok(Self { elements, distance, unit })
    }

    /// The centers of the triangles (world), m.
    #[must_use]
    pub fn centers(&self) -> &[Point3<f64>] {
        self.elements.centers()
    }

    /// Its capacity, F.
    #[must_use]
    pub fn capacity(&self) -> f64 {
        self.unit.iter().sum()
    }

    /// The charges of the triangles at a potential of 1 V without any other charge, C.
    #[must_use]
    pub fn unit_charges(&self) -> &[f64] {
        &self.unit
    }

    /// Refuses points (world, m) that are inside, by more than the error of a distance field of 64 nodes
    /// along the mesh.
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

    /// The potentials (V) that `charges` (C) at `sources` (world, m) make at the triangles: means over
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
        self.check_outside(sources)?;
        check_charges(charges, sources.len())?;
        self.elements.potentials(sources, charges, accuracy)
    }

    /// The charges of the triangles (C) when the other charges make `potentials` (V) at them.
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
        let induced = charges(&self.elements, potentials)?;
        let potential = match condition {
            Condition::Potential(potential) => potential,
            Condition::Charge(charge) => (charge + induced.iter().sum::<f64>()) / self.capacity(),
        };
        Ok(self.unit.iter().zip(&induced).map(|(unit, q)| unit * potential - q).collect())
    }

    /// The potentials and fields that triangles with the `charges` of a solution (C) make at `targets`
    /// (world, m) outside, by the multipole method of this accuracy; the forces on charges there are the gradient of their energy in the
    /// [`potentials`](Self::potentials) that they make.
    ///
    /// # Errors
    /// Targets that are inside or not finite, and charges that do not fit.
    pub fn fields(
        &self,
        charges: &[f64],
        targets: &[Point3<f64>],
        accuracy: Accuracy,
    ) -> Result<Fields, ElectrostaticsError> {
        check_charges(charges, self.unit.len())?;
        self.check_outside(targets)?;
        self.elements.fields(charges, targets, accuracy)
    }
}

/// The charges (C) that make `potentials` (V) at the triangles.
fn charges(elements: &Elements, potentials: &[f64]) -> Result<Vec<f64>, ElectrostaticsError> {
    let apply = |charges: &[f64]| elements.apply(charges);
    let (charges, residual) = solve(apply, elements.diagonal(), potentials, RESIDUAL)?;
    if residual > RESIDUAL {
        return Err(ElectrostaticsError::NoConvergence { iterations: MOST, residual });
    }
    Ok(charges)
}
