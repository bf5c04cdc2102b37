//! What triangles and the charges outside do to each other, by the multipole method.

use super::close::{add_fields, add_mean};
use super::elements::Elements;
use super::triangle::{POINTS, RULED, Triangle};
use crate::direct_sum::Cloud;
use crate::harmonics::Coefficient;
use crate::multipole::accuracy::{MARGIN, guess, thinning};
use crate::multipole::downward::{BODIES_PER_TASK, Degrees, Descent, Far, Leaf, Task};
use crate::multipole::samples::{SAMPLES, error, samples};
use crate::multipole::solver::find_order;
use crate::multipole::tree::{Cell, Octree};
use crate::multipole::upward::{Multipoles, scaled};
use crate::{Accuracy, ElectrostaticsError};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Largest ratio of radii to distance at which expansions of triangles are used.
const CONDUCTOR_OPENING: f64 = 0.7;

/// Tolerance from which on the points of a triangle may stand for it also where it is close, as far
/// as the opening lets them: that errs by some 2e-5.
const COARSE_TRIANGLES: f64 = 1e-4;

/// Number of triangles below which a subtree is one task.
const TRIANGLES_PER_TASK: usize = 64;

/// Number of pairs up to which the direct sum is taken of all.
const DIRECT: usize = 4_000_000;

/// Number of pairs of charges outside and sampled triangles, about.
const SAMPLED: usize = 100_000_000;

/// Bodies outside of the conductor.
#[derive(Clone, Copy)]
pub(crate) struct ExteriorBodies<'a> {
    /// Tree of the bodies.
    pub(crate) tree: &'a Octree,
    /// Points of the bodies, in the order of the tree.
    pub(crate) cloud: &'a Cloud,
    /// Number of points of each body.
    pub(crate) per_body: usize,
}

/// Action that adds the potentials and gradients at the points of a body to the result for it.
pub(crate) type Add<'a, const N: usize> = &'a (dyn Fn(usize, &[[f64; 4]], &mut [f64; N]) + Sync);

impl Elements {
    /// Means of `q/r` of all charges outside over each triangle, in the order of the tree of
    /// triangles, and their gradients, which are found to `accuracy`: with the multipoles and the
    /// degree that are `known`, if these do.
    pub(super) fn felt<E: Coefficient>(
        &self,
        outside: ExteriorBodies,
        known: Option<(&Multipoles<E>, usize)>,
        accuracy: Accuracy,
    ) -> Result<Vec<[f64; 4]>, ElectrostaticsError> {
        let count = self.triangles.len();
        let all = 0..outside.cloud.len();
        let direct = |triangle: usize| {
            let (mut sum, all) = ([0.0; 4], std::slice::from_ref(&all));
            add_mean(self.ordered(triangle), outside.cloud, all, &mut sum);
            sum
        };
        // Few pairs are summed directly.
        if count * outside.cloud.len() < DIRECT {
            return Ok((0..count).into_par_iter().map(direct).collect());
        }
        let multipoles =
            |order| Multipoles::<E>::new(outside.tree, outside.cloud, outside.per_body, order);
        let felt = |sources: &Multipoles<E>, order, samples: Option<&[usize]>| {
            let mut out = vec![[0.0; 4]; count];
            let leaf = &Felt { elements: self, outside };
            let grain = TRIANGLES_PER_TASK;
            let task = Descent {
                grain,
                samples,
                ..self.descent(sources, &self.tree, leaf, order, accuracy)
            };
            task.run(&mut out);
            out
        };
        // Otherwise charges outside are the sources of the multipole method and triangles its
        // targets, with the degree at which sampled triangles feel what the direct sum makes.
        let tolerance = match accuracy {
            Accuracy::Order(order) => return Ok(felt(&multipoles(order), order, None)),
            Accuracy::Tolerance(tolerance) => tolerance,
        };
        let wanted = (SAMPLED / outside.cloud.len()).clamp(SAMPLES / 4, SAMPLES);
        let samples = samples(count, wanted);
        let exact: Vec<_> = samples.par_iter().copied().map(direct).collect();
        let error = |sources: &Multipoles<E>, order| {
            error(&samples, &felt(sources, order, Some(&samples)), &exact)
        };
        if let Some((sources, order)) = known
            && error(sources, order) <= MARGIN * tolerance
        {
            return Ok(felt(sources, order, None));
        }
        let (order, sources, _) =
            find_order(guess(accuracy).div_ceil(2), tolerance, multipoles, error)?;
        Ok(felt(&sources, order, None))
    }

    /// Adds the action of the `charges` of the triangles on the bodies outside to `out`, in the
    /// order of their tree; `add` makes it of the potentials and gradients at the points of a body.
    /// Returns the relative error at samples.
    pub(super) fn make<const N: usize>(
        &self,
        charges: &[f64],
        outside: ExteriorBodies,
        accuracy: Accuracy,
        add: Add<N>,
        out: &mut [[f64; N]],
    ) -> Result<f64, ElectrostaticsError> {
        // Far away a triangle acts by its points, which share its charge.
        let ordered: Vec<_> = self.tree.order.iter().map(|&j| charges[j as usize]).collect();
        let shares = self.points.charge.iter().enumerate();
        let shared = shares.map(|(k, share)| ordered[k / POINTS] * share).collect();
        let cloud = Cloud { x: Arc::clone(&self.points.x), charge: shared };
        let multipoles = |order| Multipoles::<f64>::new(&self.tree, &cloud, POINTS, order);
        let leaf = &Made { elements: self, charges: &ordered, outside, add };
        let count = outside.tree.order.len();
        let direct = |body: usize, out: &mut [f64; N]| {
            let mut sums = vec![[0.0; 4]; outside.per_body];
            leaf.add_triangles(std::iter::once(0..ordered.len()), body..body + 1, &mut sums);
            add(body, &sums, out);
        };
        let run =
            |multipoles: &Multipoles<f64>, order, samples: Option<&[usize]>, out: &mut [_]| {
                let task = self.descent(multipoles, outside.tree, leaf, order, accuracy);
                Descent { samples, ..task }.run(out);
            };
        // Few pairs are summed directly; otherwise the degree is the one at which sampled bodies
        // feel what the direct sum makes.
        if ordered.len() * outside.cloud.len() < DIRECT {
            out.par_iter_mut().enumerate().for_each(|(body, out)| direct(body, out));
            return Ok(0.0);
        }
        let samples = samples(count, SAMPLES);
        let exact = samples.par_iter().map(|&body| {
            let mut out = [0.0; N];
            direct(body, &mut out);
            out
        });
        let exact: Vec<_> = exact.collect();
        let error = |multipoles: &Multipoles<f64>, order| {
            let mut found = vec![[0.0; N]; count];
            run(multipoles, order, Some(&samples), &mut found);
            error(&samples, &found, &exact)
        };
        let (order, multipoles, reached) = match accuracy {
            Accuracy::Tolerance(tolerance) => {
                find_order(guess(accuracy).div_ceil(2), tolerance, multipoles, error)?
            }
            Accuracy::Order(order) => {
                let multipoles = multipoles(order);
                let reached = error(&multipoles, order);
                (order, multipoles, reached)
            }
        };
        run(&multipoles, order, None, out);
        Ok(reached)
    }

    /// Descent for triangles as sources or targets, on all targets.
    fn descent<'a, L: Leaf, E: Coefficient>(
        &self,
        sources: &'a Multipoles<'a, E>,
        targets: &'a Octree,
        leaf: &'a L,
        order: usize,
        accuracy: Accuracy,
    ) -> Descent<'a, L, E> {
        let coarse =
            matches!(accuracy, Accuracy::Tolerance(tolerance) if tolerance >= COARSE_TRIANGLES);
        Descent {
            sources,
            targets,
            leaf,
            order,
            opening: CONDUCTOR_OPENING,
            degrees: Degrees::new(order, CONDUCTOR_OPENING, thinning(accuracy)),
            clearance: if coarse { 0.0 } else { RULED * self.longest },
            direct: 0,
            grain: BODIES_PER_TASK,
            samples: None,
        }
    }

    /// Triangle `k` in the order of the tree.
    fn ordered(&self, k: usize) -> &Triangle {
        &self.triangles[self.tree.order[k] as usize]
    }
}

/// Leaf action on triangles that feel the charges outside.
struct Felt<'a> {
    elements: &'a Elements,
    outside: ExteriorBodies<'a>,
}

impl Leaf for Felt<'_> {
    type Out = [f64; 4];

    fn receive(&self, cell: &Cell, far: &Far, near: &[Range<usize>], mut task: Task<[f64; 4]>) {
        let points = &self.elements.points;
        let own = scaled(&cell.bodies, POINTS);
        let mut sums = vec![[0.0; 4]; own.len()];
        far.add(cell, &points.x, own.clone(), &mut sums);
        let near: Vec<_> = near.iter().map(|near| scaled(near, self.outside.per_body)).collect();
        let shares = points.charge[own].chunks_exact(POINTS);
        let found = sums.chunks_exact(POINTS).zip(shares);
        for ((k, out), (sums, shares)) in cell.bodies.clone().zip(task.of(cell)).zip(found) {
            for (sum, share) in sums.iter().zip(shares) {
                out.iter_mut().zip(sum).for_each(|(out, x)| *out += share * x);
            }
            add_mean(self.elements.ordered(k), self.outside.cloud, &near, out);
        }
    }
}

/// Leaf action on bodies outside that feel the triangles.
struct Made<'a, const N: usize> {
    elements: &'a Elements,
    /// Charges of the triangles, in the order of their tree.
    charges: &'a [f64],
    outside: ExteriorBodies<'a>,
    /// Action at the points of a body.
    add: Add<'a, N>,
}

impl<const N: usize> Made<'_, N> {
    /// Adds to `out` the potentials and gradients that the triangles `near`, which are not far,
    /// make at the points of `bodies`.
    fn add_triangles(
        &self,
        near: impl Iterator<Item = Range<usize>>,
        bodies: Range<usize>,
        out: &mut [[f64; 4]],
    ) {
        let triangle = |k: usize| (self.elements.ordered(k), self.charges[k]);
        let triangles: Vec<_> = near.flatten().map(triangle).collect();
        let targets = scaled(&bodies, self.outside.per_body);
        add_fields(&triangles, &self.outside.cloud.x, targets, out);
    }
}

impl<const N: usize> Leaf for Made<'_, N> {
    type Out = [f64; N];

    fn receive(&self, cell: &Cell, far: &Far, near: &[Range<usize>], mut task: Task<[f64; N]>) {
        let ExteriorBodies { cloud, per_body, .. } = self.outside;
        let own = scaled(&cell.bodies, per_body);
        let mut sums = vec![[0.0; 4]; own.len()];
        far.add(cell, &cloud.x, own, &mut sums);
        self.add_triangles(near.iter().cloned(), cell.bodies.clone(), &mut sums);
        let found = cell.bodies.clone().zip(sums.chunks_exact(per_body));
        for ((body, sums), out) in found.zip(task.of(cell)) {
            (self.add)(body, sums, out);
        }
    }
}
