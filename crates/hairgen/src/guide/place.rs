use super::flow::GuideFlow;
use super::objective::{Objective, Terms};
use super::rod::{EndLoad, GuideRod};
use super::search::{Minimum, SearchStart, minimize};
use super::{GuideOptions, PreGuide};
use crate::density::HairDensity;
use crate::near::nearest;
use crate::quadrature::length;
use crate::{HairgenError, Pore, Region, cut};
use nalgebra::{Matrix6, Point3, UnitQuaternion, Vector6};
use rapunzel_rod_static::Shape;
use rayon::prelude::*;

/// Part of a guide's length that is left after the cut with which no other start is tried.
const ENOUGH: f64 = 0.9;

/// A main guide in its place.
#[derive(Debug, Clone)]
pub struct GuideHair {
    /// Number of its pore.
    pub pore: usize,
    /// Its shape before the cut: positions and frames of its nodes.
    pub shape: Shape,
    /// The load on its end that gives it this shape.
    pub load: EndLoad,
    /// The objective's terms there.
    pub terms: Terms,
    /// The objective, the weighted sum of the terms.
    pub value: f64,
    /// Number of equilibria that the search took.
    pub equilibria: usize,
    /// What the cut leaves of its center line (world), m, from the root on.
    pub curve: Vec<Point3<f64>>,
}

/// The main guides of a style, and the pores without one.
#[derive(Debug, Clone, Default)]
pub struct GuideHairs {
    /// The guides in the order of their pores.
    pub guides: Vec<GuideHair>,
    /// Numbers of the pores whose guides found no place: too little is left of them between head
    /// and hull.
    pub without_place: Vec<usize>,
}

/// Lays a guide in each of the `pores`: the load on its end, a force and a couple, is the one that
/// minimizes the objective (5.7), searched by a quasi-Newton method from the loads of the
/// pre-guides or of a guide next to it. Guides are as long as the pre-guides have found place, and
/// cut where they leave the region.
///
/// Guides are laid in batches in the order of their pores: each sees the guides of the batches
/// before, and a `density`, which grows by them. So the result does not depend on the number of
/// threads.
///
/// # Errors
/// Options out of range, pores that are none, and no pre-guides.
pub fn place_guides(
    pores: &[Pore],
    pre: &[PreGuide],
    region: Region<'_>,
    mut density: Option<&mut HairDensity>,
    options: &GuideOptions,
) -> Result<GuideHairs, HairgenError> {
    options.validate()?;
    let numbers: Vec<usize> = (0..pores.len()).collect();
    let mut hairs = GuideHairs::default();
    let mut inverses = Vec::with_capacity(pores.len());
    for batch in numbers.chunks(options.batch) {
        let known = density.as_deref();
        let place = |&number: &usize| {
            let pore = &pores[number];
            let flow = GuideFlow::at(&pore.position, pre)?;
            let objective = Objective::new(flow, region, known, options)?;
            let roots = hairs.guides.iter().map(|guide| pores[guide.pore].position);
            let near = nearest::<1, 3>(&pore.position, roots);
            let near = near.first().map(|(_, k)| (&hairs.guides[*k], inverses[*k]));
            place(pore, number, &objective, near, options)
        };
        let placed: Result<Vec<_>, _> = batch.par_iter().map(place).collect();
        for (number, guide) in batch.iter().zip(placed?) {
            let Some((guide, inverse)) = guide else {
                hairs.without_place.push(*number);
                continue;
            };
            if let Some(density) = density.as_deref_mut() {
                density.add(&guide.curve);
            }
            hairs.guides.push(guide);
            inverses.push(inverse);
        }
    }
    Ok(hairs)
}

/// A guide that has been laid, and the inverse Hessian of its objective, its forces in its root's
/// axes.
type Laid = (GuideHair, Option<Matrix6<f64>>);

/// The nearest guide that has been laid, and the inverse Hessian of its objective, its forces in
/// its root's axes.
type Neighbor<'a> = (&'a GuideHair, Option<Matrix6<f64>>);

/// The guide of a pore with its inverse Hessian; `None` if it has no equilibrium, or too little is
/// left of it after the cut.
fn place(
    pore: &Pore,
    number: usize,
    objective: &Objective<'_>,
    near: Option<Neighbor<'_>>,
    options: &GuideOptions,
) -> Result<Option<Laid>, HairgenError> {
    let mut rod = GuideRod::new(&objective.flow.limit(pore), number, options)?;
    let mut best: Option<(f64, Vec<Point3<f64>>, Minimum<Shape>)> = None;
    // Those of the first starts are counted too.
    let mut equilibria = 1 + usize::from(near.is_some());
    for (load, shape) in starts(&mut rod, objective, near) {
        let inverse = near.and_then(|(_, inverse)| Some(rotated(&inverse?, &rod.root())));
        let start = SearchStart { point: load, kept: &shape, inverse };
        let found = minimize(start, options.equilibria, |load, shape| {
            let (value, gradient, rest) = objective.with_gradient(&mut rod, load, shape)?;
            Some((value, gradient, rest.shape))
        });
        let Some(found) = found else { continue };
        equilibria += found.evaluations;
        let curve = cut(found.kept.positions(), objective.region, options.outside);
        let left = length(&curve);
        if best.as_ref().is_none_or(|(most, ..)| left > *most) {
            best = Some((left, curve, found));
        }
        if left >= ENOUGH * rod.length {
            break;
        }
    }
    let Some((left, curve, found)) = best else { return Ok(None) };
    let (terms, _) = objective.terms(&rod, &found.kept);
    let inverse = found.inverse.map(|inverse| rotated(&inverse, &rod.root().inverse()));
    let guide = GuideHair {
        pore: number,
        load: EndLoad::of(&found.point),
        terms,
        value: found.value,
        equilibria,
        curve,
        shape: found.kept,
    };
    Ok((left >= options.least * pore.length).then_some((guide, inverse)))
}

/// Loads from which the search may start, and equilibria there: first the mean load of the
/// pre-guides next to the guide and the load of the guide next to it, the better one before the
/// other, then the load of each of the pre-guides.
fn starts(
    rod: &mut GuideRod,
    objective: &Objective<'_>,
    near: Option<Neighbor<'_>>,
) -> Vec<(Vector6<f64>, Shape)> {
    let flow = &objective.flow;
    let mut first = vec![(flow.load(rod), flow.parts[0].1.shape.clone())];
    if let Some((guide, _)) = near {
        first.push((rod.moved(&guide.load, &guide.shape), guide.shape.clone()));
    }
    let mut values: Vec<_> = first
        .into_iter()
        .filter_map(|(load, shape)| {
            let (value, shape) = objective.at(rod, &load, &shape)?;
            Some((value, load, shape))
        })
        .collect();
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut starts: Vec<_> = values.into_iter().map(|(_, load, shape)| (load, shape)).collect();
    let parts =
        flow.parts.iter().map(|(_, pre)| (rod.moved(&pre.load, &pre.shape), pre.shape.clone()));
    starts.extend(parts);
    starts
}

/// An inverse Hessian whose forces are turned.
fn rotated(inverse: &Matrix6<f64>, by: &UnitQuaternion<f64>) -> Matrix6<f64> {
    let mut turn = Matrix6::identity();
    turn.fixed_view_mut::<3, 3>(0, 0).copy_from(by.to_rotation_matrix().matrix());
    turn * inverse * turn.transpose()
}
