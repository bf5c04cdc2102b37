use super::PreGuide;
use super::rod::{EndLoad, GuideRod};
use crate::near::nearest;
use crate::{HairgenError, Pore};
use nalgebra::{Point3, Vector3};
use rapunzel_rod_static::Rest;

/// Number of pre-guides that tell a guide where hair flows; three are enough (thesis 5.3.3).
const FLOWS: usize = 3;

/// Fraction of the distance to the farthest of a guide's pre-guides that is added to all distances,
/// so that a guide in the pore of a pre-guide has finite weights.
const SOFTENING: f64 = 1e-2;

/// What the pre-guides next to a guide say about its shape, node by node at equal fractions of both
/// lengths.
#[derive(Debug, Clone)]
pub(crate) struct GuideFlow<'a> {
    /// The pre-guides with their weights, whose sum is 1.
    pub(super) parts: Vec<(f64, &'a PreGuide)>,
    /// Weighted sums of the pre-guides' tangents at the nodes (world).
    pub(super) tangents: Vec<Vector3<f64>>,
}

impl<'a> GuideFlow<'a> {
    /// The pre-guides nearest to `root`, weighted with one over the distance of the roots. Those
    /// that have found no place count only where there are too few others.
    ///
    /// # Errors
    /// No pre-guides.
    pub(crate) fn at(root: &Point3<f64>, pre: &'a [PreGuide]) -> Result<Self, HairgenError> {
        let Some(first) = pre.first() else {
            let remedy = "grow them in pores at about one in a square centimeter";
            return Err(HairgenError::Nothing { what: "pre-guides", remedy });
        };
        let placed: Vec<&PreGuide> = pre.iter().filter(|guide| guide.placed).collect();
        let known = if placed.len() < FLOWS { pre.iter().collect() } else { placed };
        let near = nearest::<FLOWS, 3>(root, known.iter().map(|guide| guide.pore.position));
        let far = near.iter().map(|(distance, _)| *distance).fold(0.0, f64::max);
        let weight = |distance: f64| {
            if far > 0.0 { far / (distance + SOFTENING * far) } else { 1.0 }
        };
        let sum: f64 = near.iter().map(|(distance, _)| weight(*distance)).sum();
        let parts: Vec<_> =
            near.iter().map(|(distance, i)| (weight(*distance) / sum, known[*i])).collect();
        let nodes = first.shape.frames().len();
        let tangent = |node: usize| {
            let all =
                parts.iter().map(|(part, guide)| guide.shape.frames()[node] * Vector3::z() * *part);
            all.sum()
        };
        Ok(Self { tangents: (0..nodes).map(tangent).collect(), parts })
    }

    /// The pore with the length of its guide: its own, and not more than that of its pre-guides in
    /// the mean.
    pub(crate) fn fitted(&self, pore: &Pore) -> Pore {
        let mean: f64 = self.parts.iter().map(|(part, guide)| guide.pore.length * *part).sum();
        Pore { length: pore.length.min(mean), ..*pore }
    }

    /// Where a search for the load on the end of `rod` starts: the load of the nearest pre-guide,
    /// turned from its root to that of `rod`, and the equilibrium there next to its shape. The mean
    /// of several loads may bend a hair into none of their shapes. `None` without an equilibrium.
    pub(super) fn start(&self, rod: &mut GuideRod) -> Option<(EndLoad, Rest)> {
        let (_, near) = self.parts.first()?;
        let turn = rod.root() * near.shape.frames()[0].inverse();
        let load = EndLoad { force: turn * near.load.force, ..near.load };
        let rest = rod.relax_nearby(&load, &near.shape);
        let rest = rest.or_else(|_| rod.relax(&load, &rod.straight())).ok()?;
        Some((load, rest))
    }
}
