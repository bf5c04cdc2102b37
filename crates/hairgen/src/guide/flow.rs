use super::PreGuide;
use super::rod::GuideRod;
use crate::HairgenError;
use crate::near::nearest;
use nalgebra::{Point3, Vector3, Vector6};

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
    /// The mean of the pre-guides' end loads, their forces turned from their roots to that of
    /// `rod`.
    pub(super) fn load(&self, rod: &GuideRod) -> Vector6<f64> {
        let mut load = Vector6::zeros();
        for (part, guide) in &self.parts {
            let turn = rod.root() * guide.shape.frames()[0].inverse();
            let mut force = load.fixed_rows_mut::<3>(0);
            force += turn * guide.load.force * *part;
            let mut couple = load.fixed_rows_mut::<3>(3);
            couple += guide.load.couple * *part;
        }
        load
    }
}
