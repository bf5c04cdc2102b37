//! Charged triangles and what they do to each other and to points.

use super::triangle::Triangle;
use crate::direct_sum::{Cloud, places};
use crate::multipole::tree::Octree;
use crate::{Accuracy, COULOMB_CONSTANT, ElectrostaticsError, MultipolePlan};
use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::Mesh;
use rayon::prelude::*;

/// Distance from the center of a triangle, over its longest side, from which on it acts as a point
/// on other triangles.
const NEAR: f64 = 3.0;

/// Accuracy of the action of triangles on each other beyond that distance.
const ACCURACY: Accuracy = Accuracy::Tolerance(1e-6);

/// Number of triangles in a leaf: they are large beside what is near them.
const TRIANGLES_PER_LEAF: usize = 1;

/// Triangles with constant charge density.
#[derive(Debug)]
pub(super) struct Elements {
    /// Triangles as they stand in the mesh.
    pub(super) triangles: Vec<Triangle>,
    /// Centers of the triangles (world), m.
    centers: Vec<Point3<f64>>,
    /// Tree of the triangles.
    pub(super) tree: Octree,
    /// Longest side of all triangles, m.
    pub(super) longest: f64,
    /// Points that stand for the triangles where they are not close, in the order of the tree, with
    /// their shares.
    pub(super) points: Cloud,
    /// Trees of the centers, by which triangles act on each other as points.
    plan: MultipolePlan,
    /// Close triangles of each center, and by how much more than points they act, 1/m.
    excess: Vec<Vec<(usize, f64)>>,
    /// Potentials of triangles at their own centers, V/C.
    diagonal: Vec<f64>,
}

impl Elements {
    /// Triangles of `mesh`, with what close ones do to each other.
    pub(super) fn new(mesh: &Mesh) -> Result<Self, ElectrostaticsError> {
        let corner = |vertex: u32| mesh.vertices()[vertex as usize];
        let triangles: Vec<_> =
            mesh.triangles().iter().map(|t| Triangle::new(t.map(corner))).collect();
        let centers: Vec<_> = triangles.iter().map(Triangle::center).collect();
        let tree = Octree::new(centers.len(), TRIANGLES_PER_LEAF, |i| triangles[i].corners());
        let longest = triangles.iter().map(Triangle::longest).fold(0.0, f64::max);
        let plan = MultipolePlan::new(&centers, &centers, ACCURACY)?;
        let ordered = tree.order.iter().map(|&triangle| &triangles[triangle as usize]);
        let (points, shares): (Vec<_>, _) = ordered.flat_map(Triangle::points).unzip();
        let points = Cloud::new(places(points.into_par_iter()), shares);
        let (excess, diagonal) = (Vec::new(), Vec::new());
        let mut all = Self { triangles, centers, tree, longest, points, plan, excess, diagonal };
        let excess = |(i, x): (usize, &Point3<f64>)| {
            let mut excess = Vec::new();
            all.near(x, |j| excess.push((j, all.triangles[j].mean(x) - all.point(i, j))));
            excess
        };
        all.excess = all.centers.par_iter().enumerate().map(excess).collect();
        let own = |(t, x): (&Triangle, &Point3<f64>)| COULOMB_CONSTANT * t.mean(x);
        all.diagonal = all.triangles.iter().zip(&all.centers).map(own).collect();
        Ok(all)
    }

    /// Centers of the triangles (world), m.
    pub(super) fn centers(&self) -> &[Point3<f64>] {
        &self.centers
    }

    /// Potentials of triangles at their own centers, V/C.
    pub(super) fn diagonal(&self) -> &[f64] {
        &self.diagonal
    }

    /// Potential (1/m) that a unit charge on triangle j as a point makes at the center of i; a
    /// point does not feel itself.
    fn point(&self, i: usize, j: usize) -> f64 {
        if i == j { 0.0 } else { inverse(self.centers[i] - self.centers[j]) }
    }

    /// Visits the triangles whose centers are closer to `x` than [`NEAR`] times their longest side.
    fn near(&self, x: &Point3<f64>, mut visit: impl FnMut(usize)) {
        let mut stack = vec![0];
        while let Some(cell) = stack.pop().and_then(|k: usize| self.tree.cells.get(k)) {
            let reach = cell.radius + NEAR * self.longest;
            if (cell.center - x).norm_squared() > reach * reach {
                continue;
            }
            stack.extend(cell.children.clone());
            if cell.is_leaf() {
                for j in self.tree.order[cell.bodies.clone()].iter().map(|j| *j as usize) {
                    let reach = NEAR * self.triangles[j].longest();
                    if (self.centers[j] - x).norm_squared() < reach * reach {
                        visit(j);
                    }
                }
            }
        }
    }

    /// Potentials (V) that `charges` of the triangles (C) make at all centers.
    pub(super) fn apply(&self, charges: &[f64]) -> Result<Vec<f64>, ElectrostaticsError> {
        let mut potentials = self.plan.fields(charges)?.0.potentials;
        potentials.par_iter_mut().zip(&self.excess).for_each(|(potential, excess)| {
            let more: f64 = excess.iter().map(|(j, more)| charges[*j] * more).sum();
            *potential += COULOMB_CONSTANT * more;
        });
        Ok(potentials)
    }
}

/// Inverse length of `r`, 1/m; zero for zero, as a charge does not feel itself.
fn inverse(r: Vector3<f64>) -> f64 {
    let length = r.norm();
    if length > 0.0 { 1.0 / length } else { 0.0 }
}
