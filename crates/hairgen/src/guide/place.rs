use super::flow::GuideFlow;
use super::objective::{Objective, Terms};
use super::rod::{EndLoad, GuideRod};
use super::search::{Minimum, Start, minimize};
use super::{GuideOptions, PreGuide};
use crate::density::HairDensity;
use crate::near::nearest;
use crate::quadrature::length;
use crate::{HairgenError, Pore, Region, cut};
use nalgebra::{Matrix6, Point3, UnitQuaternion, Vector6};
use rapunzel_rod_static::Shape;
use rayon::prelude::*;

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

/// The nearest guide that has been laid, and the inverse Hessian of its objective, its forces in its
/// root's axes.
type Neighbor<'a> = (&'a GuideHair, Option<Matrix6<f64>>);

/// The guide of a pore with its inverse Hessian; `None` if it has no equilibrium, or too little is
/// left of it after the cut.
fn place(
    pore: &Pore,
    number: usize,
    objective: &Objective<'_>,
    near: Option<Neighbor<'_>>,
    options: &GuideOptions,
) -> Result<Option<(GuideHair, Option<Matrix6<f64>>)>, HairgenError> {
    let mut rod = GuideRod::new(&objective.flow.limit(pore), number, options)?;
    let Some(found) = optimum(&mut rod, objective, near, options.equilibria) else {
        return Ok(None);
    };
    let (terms, _) = objective.terms(&rod, &found.kept);
    let curve = cut(found.kept.positions(), objective.region, options.outside);
    let left = length(&curve);
    let inverse = found.inverse.map(|inverse| rotated(&inverse, &rod.root().inverse()));
    let guide = GuideHair {
        pore: number,
        load: EndLoad::of(&found.point),
        terms,
        value: found.value,
        equilibria: found.evaluations,
        curve,
        shape: found.kept,
    };
    Ok((left >= options.least * pore.length).then_some((guide, inverse)))
}

/// The end load that minimizes the objective, in at most `most` equilibria: searched from the mean
/// load of the pre-guides next to the guide or from the load of the guide next to it, whichever is
/// better.
fn optimum(
    rod: &mut GuideRod,
    objective: &Objective<'_>,
    near: Option<Neighbor<'_>>,
    most: usize,
) -> Option<Minimum<Shape>> {
    let point = objective.flow.load(rod);
    let mut starts: Vec<(Vector6<f64>, &Shape)> = vec![(point, objective.flow.shape())];
    if let Some((guide, _)) = near {
        starts.push((rod.moved(&guide.load, &guide.shape), &guide.shape));
    }
    let values = starts.into_iter().filter_map(|(load, shape)| {
        let (value, shape) = objective.at(rod, &load, shape)?;
        Some((value, load, shape))
    });
    let (_, point, shape) = values.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let inverse = near.and_then(|(_, inverse)| Some(rotated(&inverse?, &rod.root())));
    minimize(Start { point, kept: &shape, inverse }, most, |load, shape| {
        let (value, gradient, rest) = objective.with_gradient(rod, load, shape)?;
        Some((value, gradient, rest.shape))
    })
}

/// An inverse Hessian whose forces are turned.
fn rotated(inverse: &Matrix6<f64>, by: &UnitQuaternion<f64>) -> Matrix6<f64> {
    let mut turn = Matrix6::identity();
    turn.fixed_view_mut::<3, 3>(0, 0).copy_from(by.to_rotation_matrix().matrix());
    turn * inverse * turn.transpose()
}
