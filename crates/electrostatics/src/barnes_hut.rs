//! The tree code of Barnes and Hut.

use crate::direct_sum::{Cloud, add_pairs, places};
use crate::error::{check_charges, check_positions};
use crate::harmonics::{Gradient, HarmonicTables, count, regular_at};
use crate::method::{Fields, Method};
use crate::multipole::tree::Octree;
use crate::multipole::upward::Multipoles;
use crate::{ElectrostaticsError, MAX_ORDER};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Tree code of Barnes and Hut (1986), a reference: each target on its own sums the multipoles of
/// cells that are small for their distance. Cost O(n log n).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BarnesHut {
    /// Largest ratio of the radius of a cell to its distance at which its multipole is used, in (0,
    /// 1).
    pub opening: f64,
    /// Degree of the multipoles, up to [`MAX_ORDER`].
    pub order: usize,
}

impl Method for BarnesHut {
    fn fields(
        &self,
        sources: &[Point3<f64>],
        charges: &[f64],
        targets: &[Point3<f64>],
    ) -> Result<Fields, ElectrostaticsError> {
        let Self { opening: value, order } = *self;
        if !(value > 0.0 && value < 1.0) {
            let (what, range) = ("the opening", "between 0 and 1");
            return Err(ElectrostaticsError::Setting { what, value, range });
        }
        if order > MAX_ORDER {
            let (what, range, value) = ("the order", "at most 40", order as f64);
            return Err(ElectrostaticsError::Setting { what, value, range });
        }
        check_positions("source", sources)?;
        check_positions("target", targets)?;
        check_charges(charges, sources.len())?;
        let tree = Octree::new(sources.len(), 32, |i| [sources[i]]);
        let sorted = tree.order.par_iter().map(|&i| i as usize);
        let charge = sorted.clone().map(|i| charges[i]).collect();
        let cloud = Cloud::new(places(sorted.map(|i| sources[i])), charge);
        let multipoles = Multipoles::new(&tree, &cloud, 1, order);
        let gradients: Vec<_> = (0..tree.cells.len())
            .into_par_iter()
            .map(|cell| {
                let mut gradient = Gradient::default();
                let scale = tree.cells[cell].scale;
                gradient.set(HarmonicTables::get(), order, scale, multipoles.moments(cell));
                gradient
            })
            .collect();
        let places = places(targets.par_iter().copied());
        let walk = Walk { tree: &tree, gradients: &gradients, cloud: &cloud, places: &places };
        let sums: Vec<_> =
            (0..targets.len()).into_par_iter().map(|k| walk.sum(*self, k, &targets[k])).collect();
        Ok(Fields::new(1.0, sums.len(), |i| sums[i]))
    }
}

/// Sources that targets walk through.
struct Walk<'a> {
    tree: &'a Octree,
    gradients: &'a [Gradient],
    cloud: &'a Cloud,
    places: &'a [Vec<f64>; 3],
}

impl Walk<'_> {
    /// Potential (1/m) and its gradient (1/m^2), for the charges of the sources, at the target
    /// `index`.
    fn sum(&self, method: BarnesHut, index: usize, target: &Point3<f64>) -> [f64; 4] {
        let mut out = [[0.0; 4]];
        let mut near = Vec::new();
        let mut stack: Vec<_> = (0..self.tree.cells.len().min(1)).collect();
        while let Some(k) = stack.pop() {
            let cell = &self.tree.cells[k];
            let x = target - cell.center;
            if cell.radius < method.opening * x.norm() {
                add_multipole(method.order, cell.scale, &self.gradients[k], x, &mut out[0]);
            } else if cell.is_leaf() {
                near.push(cell.bodies.clone());
            } else {
                stack.extend(cell.children.clone());
            }
        }
        add_pairs(self.cloud, &near, 0.0, self.places, index..index + 1, &mut out);
        out[0]
    }
}

/// Adds the potential of a multipole and its gradient at `x` (m) from its center. Of each degree,
/// with `H_n = sum M_nm R_nm(x)`, the potential is `scale^n H_n / r^(2n+1)`.
fn add_multipole(
    order: usize,
    scale: f64,
    gradient: &Gradient,
    x: Vector3<f64>,
    out: &mut [f64; 4],
) {
    let r = x.norm();
    let unit = x / r;
    let mut values = [0.0; count(MAX_ORDER)];
    regular_at(HarmonicTables::get(), order, unit.into(), &mut values[..count(order)]);
    // Degree n of the unit direction times scale^n / r^(n+1).
    let dot = |n: usize, c: usize| -> f64 {
        (n * n..count(n)).map(|k| gradient.terms[k][c] * values[k]).sum()
    };
    let mut power = 1.0 / r;
    for n in 0..=order {
        let potential = dot(n, 0) * power;
        out[0] += potential;
        for c in 0..3 {
            // The gradient of the degree n is an expansion of degree n - 1.
            let rising = if n > 0 { dot(n - 1, c + 1) * power * (scale / r) } else { 0.0 };
            out[c + 1] += rising - (2 * n + 1) as f64 * potential * unit[c] / r;
        }
        power *= scale / r;
    }
}
