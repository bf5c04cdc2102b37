//! A conductor of any shape, by boundary elements.

use super::Condition;
use super::triangle::Triangle;
use crate::error::{check_charges, check_count};
use crate::{COULOMB_CONSTANT, ElectrostaticsError};
use nalgebra::{DMatrix, DVector, Dyn, LU, Point3};
use rapunzel_collision::field::Mesh;
use rayon::prelude::*;

/// Most triangles: the factors take eight bytes for each pair.
const MOST: usize = 8192;

/// A conductor whose surface is a mesh, factorized once.
///
/// The charge density is constant on each triangle, and the potential is right at their centers; the
/// integrals are exact. The error falls as the square of the triangles' size where the surface is
/// smooth. Cost: n^3/3 multiply-adds once, n^2 for each solution, for n triangles.
#[derive(Debug)]
pub struct ConductingSurface {
    centers: Vec<Point3<f64>>,
    factors: LU<f64, Dyn, Dyn>,
    /// Charges of the triangles at a potential of 1 V, C.
    unit: DVector<f64>,
}

impl ConductingSurface {
    /// A closed surface.
    ///
    /// # Errors
    /// More than 8192 triangles.
    pub fn new(mesh: &Mesh) -> Result<Self, ElectrostaticsError> {
        let count = mesh.triangles().len();
        if count > MOST {
            let (what, range) = ("the number of triangles", "at most 8192; take a coarser mesh");
            return Err(ElectrostaticsError::Setting { what, value: count as f64, range });
        }
        let corner = |vertex: u32| mesh.vertices()[vertex as usize];
        let triangles: Vec<_> =
            mesh.triangles().iter().map(|t| Triangle::new(t.map(corner))).collect();
        let centers: Vec<_> = triangles.iter().map(Triangle::center).collect();
        // Column by column: the potential of each triangle at all centers.
        let columns: Vec<f64> = triangles
            .par_iter()
            .flat_map_iter(|triangle| {
                centers.iter().map(|center| COULOMB_CONSTANT * triangle.potential(center))
            })
            .collect();
        let factors = DMatrix::from_vec(count, count, columns).lu();
        let unit =
            factors.solve(&DVector::repeat(count, 1.0)).unwrap_or_else(|| DVector::zeros(count));
        Ok(Self { centers, factors, unit })
    }

    /// Where the potential of all other charges must be known: the centers of the triangles (world),
    /// m. The charges of a solution are there, too.
    #[must_use]
    pub fn centers(&self) -> &[Point3<f64>] {
        &self.centers
    }

    /// Its capacity, F.
    #[must_use]
    pub fn capacity(&self) -> f64 {
        self.unit.sum()
    }

    /// The charges of the triangles (C) when the other charges make `potentials` (V) at the
    /// [`centers`](Self::centers). As points they make the field outside, to the square of the ratio
    /// of the triangles' size to the distance.
    ///
    /// # Errors
    /// Potentials that are not finite or not one for each triangle.
    pub fn charges(
        &self,
        potentials: &[f64],
        condition: Condition,
    ) -> Result<Vec<f64>, ElectrostaticsError> {
        check_count("potentials", potentials.len(), self.centers.len())?;
        check_charges(potentials, self.centers.len())?;
        let count = self.centers.len();
        let outer = DVector::from_column_slice(potentials);
        let induced = self.factors.solve(&outer).unwrap_or_else(|| DVector::zeros(count));
        let potential = match condition {
            Condition::Potential(potential) => potential,
            Condition::Charge(charge) => (charge + induced.sum()) / self.capacity(),
        };
        Ok((&self.unit * potential - induced).as_slice().to_vec())
    }
}
