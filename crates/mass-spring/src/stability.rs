use crate::tangent::Tangent;
use crate::{NodeVectors, System};
use nalgebra::DVector;
use rapunzel_linalg::largest_eigenvalue;
use std::fmt;

impl<const D: usize> System<D> {
    /// The largest time step for which the leapfrog is stable, s: `2 / omega_max` without dampers
    /// and `4 / (c + sqrt(c^2 + 4 omega_max^2))` with them, where `c` is the largest rate of decay
    /// that they cause; infinite without springs.
    ///
    /// `omega_max` is that of the present state, found by Lanczos's method without matrices, to a
    /// part in 1e6; springs that stretch later may raise it up to `sqrt(2)` times.
    #[must_use]
    pub fn stability_limit(&self) -> f64 {
        let elastic = Tangent::new(self, &self.positions, 0.0, 0.0, false);
        let square = self.largest_eigenvalue(|z, y| elastic.apply(z, y)).max(0.0);
        let decay = if self.springs.damped {
            let both = Tangent::new(self, &self.positions, 0.0, 1.0, false);
            let mut only_elastic = NodeVectors::zeros(self.nodes());
            self.largest_eigenvalue(|z, y| {
                both.apply(z, y);
                elastic.apply(z, &mut only_elastic);
                y.add_scaled(-1.0, &only_elastic);
            })
        } else {
            0.0
        };
        4.0 / (decay + (decay * decay + 4.0 * square).sqrt())
    }

    /// Warning if a step is above the stability limit, else `None`.
    #[must_use]
    pub fn warn_of_step(&self, dt: f64) -> Option<StepTooLong> {
        let limit = self.stability_limit();
        // A step at the limit itself grows without bound, if slowly.
        (dt >= limit).then_some(StepTooLong { dt, limit, method: "leapfrog" })
    }

    /// Largest eigenvalue of a matrix given by its product, in the metric of the masses; infinite
    /// if the result is NaN.
    fn largest_eigenvalue(
        &self,
        mut apply: impl FnMut(&NodeVectors<D>, &mut NodeVectors<D>),
    ) -> f64 {
        let nodes = self.nodes();
        let roots: Vec<f64> = self.inverse_masses.iter().map(|m| m.sqrt()).collect();
        let project =
            |c: &mut NodeVectors<D>| self.supports.project_weighted(c, |node| 1.0 / roots[node]);
        let scale = |columns: &mut NodeVectors<D>| {
            for column in &mut columns.0 {
                column.iter_mut().zip(&roots).for_each(|(x, root)| *x *= root);
            }
        };
        // Of no symmetry, so that no mode is left out.
        let seed = |axis: usize, node: usize| ((node * D + axis) as f64 * 1.618_034).fract() - 0.5;
        let mut from =
            NodeVectors(std::array::from_fn(|axis| (0..nodes).map(|n| seed(axis, n)).collect()));
        project(&mut from);
        let start = DVector::from_iterator(D * nodes, from.0.iter().flatten().copied());
        let mut to = NodeVectors::zeros(nodes);
        let largest = largest_eigenvalue(start, |z, y| {
            for (axis, column) in from.0.iter_mut().enumerate() {
                column.copy_from_slice(&z.as_slice()[axis * nodes..][..nodes]);
            }
            scale(&mut from);
            apply(&from, &mut to);
            scale(&mut to);
            project(&mut to);
            for (axis, column) in to.0.iter().enumerate() {
                y.as_mut_slice()[axis * nodes..][..nodes].copy_from_slice(column);
            }
        });
        largest.unwrap_or(f64::INFINITY)
    }
}

/// A warning: a step is above the stability limit of an explicit method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepTooLong {
    /// Step size, s.
    pub dt: f64,
    /// Stability limit of the step size, s.
    pub limit: f64,
    /// Name of the method.
    pub method: &'static str,
}

impl fmt::Display for StepTooLong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { dt, limit, method } = self;
        write!(
            f,
            "the time step of {dt:e} s is not below the stability limit of {limit:e} s: the \
             {method} will blow up; take smaller steps or the implicit integrator"
        )
    }
}
