use super::GuideOptions;
use super::layer::Layer;
use super::rod::{EndLoad, GuideRod};
use super::search::{Minimum, SearchStart, minimize};
use crate::error::choice;
use crate::quadrature::length;
use crate::{HairgenError, Pore, Region, cut};
use nalgebra::{Matrix6, Vector3, Vector6};
use rapunzel_rod_static::Shape;
use rayon::prelude::*;

/// First force on the end of a pre-guide, `EI / L^2`.
const FIRST_FORCE: f64 = 0.2;
/// Factor by which the force grows.
const FORCE_GROWTH: f64 = 1.15;
/// Largest force: it bends the rod within a tenth of its length.
const LARGEST_FORCE: f64 = 100.0;
/// Length of a pre-guide at first, m.
const FIRST_LENGTH: f64 = 0.02;
/// Factor by which it grows.
const GROWTH: f64 = 1.4;
/// Largest number of equilibria at each length.
const EQUILIBRIA: usize = 20;
/// Largest number of times that the search at a length is started again.
const RESTARTS: usize = 2;

/// A pre-guide: a hair that is kept so deep below the hull by a load on its end while it grows
/// (thesis 5.3.3). Pre-guides tell the main guides where hair flows.
#[derive(Debug, Clone)]
pub struct PreGuide {
    /// The pore it grows out of.
    pub pore: Pore,
    /// Length up to which it has found place, m: that of its pore or less.
    pub length: f64,
    /// Its shape: positions and frames of its nodes.
    pub shape: Shape,
    /// Curvatures of its segments times its length, in their own axes.
    pub bends: Vec<Vector3<f64>>,
    /// Load on its end.
    pub load: EndLoad,
    /// Whether all of it is deep enough and none in the head.
    pub placed: bool,
}

/// The pre-guides of the `pores`, in their order.
///
/// `dips` says for each how deep it must go, from 0, just below the hull, to 1, at the head: the
/// depth below the hull over the sum of both distances, which counts no more than at the pore. A
/// growing force is tried first, as in the thesis. It bends a hair to an arc, which does not follow
/// a head for long: where it fails the load is a force and a couple, found by a quasi-Newton
/// method, and it grows with the hair, from a length of 2 cm in steps. The hair ends before its
/// pore's length where it would leave the region for more than is tolerated: hair that hangs down
/// is cut at the hem.
///
/// # Errors
/// Options out of range, pores that are none, and dips that are not in [0, 1] or not one for each
/// pore.
pub fn grow_pre_guides(
    pores: &[Pore],
    dips: &[f64],
    region: Region<'_>,
    options: &GuideOptions,
) -> Result<Vec<PreGuide>, HairgenError> {
    options.validate()?;
    if dips.len() != pores.len() {
        let (given, wanted) = (dips.len(), pores.len());
        return Err(HairgenError::Count { what: "the dips of the pre-guides", given, wanted });
    }
    for dip in dips {
        choice("the dip of a pre-guide", *dip, "in [0, 1]", |x| (0.0..=1.0).contains(&x))?;
    }
    let grow = |number: usize| grow(&pores[number], number, dips[number], region, options);
    (0..pores.len()).into_par_iter().map(grow).collect()
}

/// Dips of pre-guides by the heights of their pores, m: from `shallow` for the highest pore to
/// `deep` for the lowest, linear in between, so that lower layers of hair lie closer to the head
/// (thesis 5.3.3). Heights may be geodesic or plain. All are `shallow` where all heights are one.
#[must_use]
pub fn dips_by_height(heights: &[f64], shallow: f64, deep: f64) -> Vec<f64> {
    let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let dip = |height: &f64| {
        let fall = if high > low { (high - height) / (high - low) } else { 0.0 };
        shallow + fall * (deep - shallow)
    };
    heights.iter().map(dip).collect()
}

fn grow(
    pore: &Pore,
    number: usize,
    dip: f64,
    region: Region<'_>,
    options: &GuideOptions,
) -> Result<PreGuide, HairgenError> {
    let layer = Layer::over(pore, dip, region, options);
    let mut rod = GuideRod::new(pore, number, options)?;
    if let Some((load, shape)) = pushed(&mut rod, &layer) {
        let (length, bends) = (pore.length, rod.bends(&shape));
        return Ok(PreGuide { pore: *pore, length, bends, load, placed: true, shape });
    }
    let straight = rod.straight();
    let mut grown = Growth { length: 0.0, load: Vector6::zeros(), shape: straight, inverse: None };
    let to = |grown: &Growth, length: f64| -> Result<Option<Growth>, HairgenError> {
        let mut rod = GuideRod::new(&Pore { length, ..*pore }, number, options)?;
        Ok(grown.to(&mut rod, &layer))
    };
    let mut length = FIRST_LENGTH.min(pore.length);
    // Until all of it has grown, or more is cut off again.
    while let Some(next) = to(&grown, length)? {
        let left = next.kept(region, options.outside);
        if left < 1.0 {
            let length = left * length;
            if length > grown.length
                && let Some(next) = to(&grown, length)?
                && next.kept(region, options.outside) == 1.0
            {
                grown = next;
            }
            break;
        }
        grown = next;
        if length >= pore.length {
            break;
        }
        length = (GROWTH * length).min(pore.length);
    }
    // A hair that hangs down to the hem ends as deep above it as elsewhere below the hull.
    let nodes = grown.shape.positions();
    let shallow = nodes.iter().rev().take_while(|node| !layer.holds(node)).count();
    let end = grown.length * shallow as f64 / (nodes.len() - 1) as f64;
    if shallow > 0
        && end < grown.length.min(2.0 * layer.depth())
        && let Some(next) = to(&grown, grown.length - end)?
    {
        grown = next;
    }
    let Growth { length, load, shape, .. } = grown;
    let placed = length > 0.0 && layer.holds_all(&shape);
    let bends = rod.bends(&shape);
    Ok(PreGuide { pore: *pore, length, bends, load: EndLoad::of(&load), placed, shape })
}

/// The least of some forces on the end, across the root and toward the head, under which all of a
/// hair is deep enough (thesis 5.3.3), and its shape.
fn pushed(rod: &mut GuideRod, layer: &Layer<'_>) -> Option<(EndLoad, Shape)> {
    let across = rod.root() * Vector3::x();
    let (mut force, mut shape) = (0.0, rod.straight());
    while force <= LARGEST_FORCE {
        let load = EndLoad { force: across * force, couple: Vector3::zeros() };
        shape = rod.relax(&load, &shape).ok()?.shape;
        if layer.holds_all(&shape) {
            return Some((load, shape));
        }
        force = FIRST_FORCE.max(FORCE_GROWTH * force);
    }
    None
}

/// A pre-guide that grows.
struct Growth {
    length: f64,
    load: Vector6<f64>,
    shape: Shape,
    inverse: Option<Matrix6<f64>>,
}

impl Growth {
    /// What it becomes at the length of `rod`. In units of stiffness and length the load is at
    /// first as before, so that the shape is the same but for its size.
    fn to(&self, rod: &mut GuideRod, layer: &Layer<'_>) -> Option<Self> {
        let mut search = |start: SearchStart<'_, Shape>| {
            minimize(start, EQUILIBRIA, |load, shape| {
                let rest = rod.relax_nearby(&EndLoad::of(load), shape).ok()?;
                let (cost, by) = layer.cost(rod, &rest.shape);
                let gradient = rod.by_load(&rest, &by).ok()?;
                cost.is_finite().then_some((cost, gradient, rest.shape))
            })
        };
        let start = SearchStart { point: self.load, kept: &self.shape, inverse: self.inverse };
        let mut found = search(start)?;
        // The inverse Hessian of another length may mislead.
        for _ in 0..RESTARTS {
            if layer.holds_all(&found.kept) {
                break;
            }
            found = search(SearchStart { point: found.point, kept: &found.kept, inverse: None })?;
        }
        let Minimum { point, kept, inverse, .. } = found;
        Some(Self { length: rod.length, load: point, shape: kept, inverse })
    }

    /// The part of its length that is left after the cut.
    fn kept(&self, region: Region<'_>, outside: f64) -> f64 {
        let positions = self.shape.positions();
        let left = cut(positions, region, outside);
        if left == positions { 1.0 } else { length(&left) / length(positions) }
    }
}
