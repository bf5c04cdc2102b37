//! Charged triangles and what they do to each other and to points.

use super::triangle::{POINTS, RULED, Triangle};
use crate::multipole::tree::Tree;
use crate::{Accuracy, COULOMB_CONSTANT, ElectrostaticsError, Fields, Method, Multipole, Plan};
use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::Mesh;
use rayon::prelude::*;

/// Distance from a triangle's center, over its longest side, from which on it acts as a point on other
/// triangles.
const NEAR: f64 = 3.0;

/// Accuracy of what triangles do to each other beyond.
const ACCURACY: Accuracy = Accuracy::Tolerance(1e-6);

/// Triangles with constant charge.
#[derive(Debug)]
pub(super) struct Elements {
    triangles: Vec<Triangle>,
    centers: Vec<Point3<f64>>,
    tree: Tree,
    /// The longest side of all.
    longest: f64,
    /// The points that stand for the triangles where they are not close, one triangle after another, and
    /// their shares.
    points: Vec<Point3<f64>>,
    shares: Vec<f64>,
    plan: Plan,
    /// For each center the triangles that are close, and by how much more than points they act.
    excess: Vec<Vec<(usize, f64)>>,
    /// Potentials of triangles at their own centers, V/C.
    diagonal: Vec<f64>,
}

impl Elements {
    pub(super) fn new(mesh: &Mesh) -> Result<Self, ElectrostaticsError> {
        let corner = |vertex: u32| mesh.vertices()[vertex as usize];
        let triangles: Vec<_> =
            mesh.triangles().iter().map(|t| Triangle::new(t.map(corner))).collect();
        let centers: Vec<_> = triangles.iter().map(Triangle::center).collect();
        let tree = Tree::new(centers.len(), 16, |i| [centers[i]; 2]);
        let longest = triangles.iter().map(Triangle::longest).fold(0.0, f64::max);
        let plan = Plan::new(&centers, &centers, ACCURACY)?;
        let (points, shares) = triangles.iter().flat_map(Triangle::points).unzip();
        let (excess, diagonal) = (Vec::new(), Vec::new());
        let mut all =
            Self { triangles, centers, tree, longest, points, shares, plan, excess, diagonal };
        let excess = |(i, x): (usize, &Point3<f64>)| {
            let seen = |j: usize| {
                let triangle = &all.triangles[j];
                if triangle.is_close(x) { triangle.exact(x).0 } else { triangle.by_points(x).0 }
            };
            let mut excess = Vec::new();
            all.near(x, NEAR, |j| excess.push((j, seen(j) - all.point(i, j))));
            excess
        };
        all.excess = all.centers.par_iter().enumerate().map(excess).collect();
        let own = |(t, x): (&Triangle, &Point3<f64>)| COULOMB_CONSTANT * t.exact(x).0;
        all.diagonal = all.triangles.iter().zip(&all.centers).map(own).collect();
        Ok(all)
    }

    pub(super) fn centers(&self) -> &[Point3<f64>] {
        &self.centers
    }

    pub(super) fn diagonal(&self) -> &[f64] {
        &self.diagonal
    }

    /// What the charge of triangle j as a point makes at the center of i; a point does not feel itself.
    fn point(&self, i: usize, j: usize) -> f64 {
        if i == j { 0.0 } else { inverse(self.centers[i] - self.centers[j]) }
    }

    /// Visits the triangles whose centers are closer to `x` than `times` their longest side.
    fn near(&self, x: &Point3<f64>, times: f64, mut visit: impl FnMut(usize)) {
        let mut stack = vec![0];
        while let Some(cell) = stack.pop().and_then(|k: usize| self.tree.cells.get(k)) {
            let reach = cell.radius + times * self.longest;
            if (cell.center - x).norm_squared() > reach * reach {
                continue;
            }
            stack.extend(cell.children.clone());
            if cell.is_leaf() {
                for j in self.tree.order[cell.bodies.clone()].iter().map(|j| *j as usize) {
                    let reach = times * self.triangles[j].longest();
                    if (self.centers[j] - x).norm_squared() < reach * reach {
                        visit(j);
                    }
                }
            }
        }
    }

    /// By how much more than its points a triangle with the charge 1 makes at `x`: `1/r` and its gradient.
    fn more_than_points(&self, j: usize, x: &Point3<f64>) -> (f64, Vector3<f64>) {
        let triangle = &self.triangles[j];
        let ((mean, gradient), rule) = (triangle.exact(x), triangle.by_points(x));
        (mean - rule.0, gradient - rule.1)
    }

    /// The potentials (V) that `charges` of the triangles (C) make at all centers.
    pub(super) fn apply(&self, charges: &[f64]) -> Result<Vec<f64>, ElectrostaticsError> {
        let mut potentials = self.plan.fields(charges)?.0.potentials;
        potentials.par_iter_mut().zip(&self.excess).for_each(|(potential, excess)| {
            let more: f64 = excess.iter().map(|(j, more)| charges[*j] * more).sum();
            *potential += COULOMB_CONSTANT * more;
        });
        Ok(potentials)
    }

    /// The potentials (V) that points make at the triangles.
    pub(super) fn potentials(
        &self,
        sources: &[Point3<f64>],
        charges: &[f64],
        accuracy: Accuracy,
    ) -> Result<Vec<f64>, ElectrostaticsError> {
        let at_points = Multipole { accuracy }.fields(sources, charges, &self.points)?.potentials;
        let shared: Vec<_> =
            at_points.iter().zip(&self.shares).map(|(v, share)| v * share).collect();
        let mut potentials: Vec<f64> =
            shared.chunks_exact(POINTS).map(|points| points.iter().sum()).collect();
        let more = |x: &Point3<f64>| {
            let mut more = Vec::new();
            self.near(x, RULED, |j| more.push((j, self.more_than_points(j, x).0)));
            more
        };
        let near: Vec<_> = sources.par_iter().map(more).collect();
        for (near, charge) in near.iter().zip(charges) {
            for (j, more) in near {
                potentials[*j] += COULOMB_CONSTANT * charge * more;
            }
        }
        Ok(potentials)
    }

    /// The fields that `charges` of the triangles (C) make at points.
    pub(super) fn fields(
        &self,
        charges: &[f64],
        targets: &[Point3<f64>],
        accuracy: Accuracy,
    ) -> Result<Fields, ElectrostaticsError> {
        let shared = |(k, share): (usize, &f64)| charges[k / POINTS] * share;
        let shared: Vec<_> = self.shares.iter().enumerate().map(shared).collect();
        let mut fields = Multipole { accuracy }.fields(&self.points, &shared, targets)?;
        let found = fields.potentials.par_iter_mut().zip(&mut fields.fields).zip(targets);
        found.for_each(|((potential, field), x)| {
            self.near(x, RULED, |j| {
                let charge = COULOMB_CONSTANT * charges[j];
                let (more, gradient) = self.more_than_points(j, x);
                *potential += charge * more;
                *field -= charge * gradient;
            });
        });
        Ok(fields)
    }
}

/// The inverse length of `r`; zero for zero, as a charge does not feel itself.
fn inverse(r: Vector3<f64>) -> f64 {
    let length = r.norm();
    if length > 0.0 { 1.0 / length } else { 0.0 }
}
