use super::flow::GuideFlow;
use super::objective::{Objective, Terms};
use super::rod::{EndLoad, GuideRod};
use super::search::{Minimum, Searched, minimize};
use super::{GuideOptions, PreGuide};
use crate::density::HairDensity;
use crate::{HairgenError, Pore, Region, cut};
use nalgebra::{Matrix6, Point3, Vector6};
use rapunzel_rod_static::{Rest, Shape};
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
/// minimizes the objective (5.7), searched by a quasi-Newton method from the load of the
/// pre-guide next to it. A guide is as long as its pore says, and not longer than the pre-guides
/// next to it in the mean, which end where they leave the region; it is cut where it leaves it.
///
/// With a `density`, which grows by the guides laid, guides are laid in batches in the order of
/// their pores: each sees the guides of the batches before. So the result does not depend on the
/// number of threads.
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
    for batch in numbers.chunks(options.batch) {
        let known = density.as_deref();
        let place = |&number: &usize| {
            let flow = GuideFlow::at(&pores[number].position, pre)?;
            let objective = Objective::new(flow, region, known, options)?;
            place(&pores[number], number, &objective, options)
        };
        let placed: Result<Vec<_>, _> = batch.par_iter().map(place).collect();
        for (number, guide) in batch.iter().zip(placed?) {
            let Some(guide) = guide else {
                hairs.without_place.push(*number);
                continue;
            };
            if let Some(density) = density.as_deref_mut() {
                density.add(&guide.curve);
            }
            hairs.guides.push(guide);
        }
    }
    Ok(hairs)
}

/// The guide of a pore; `None` if it has no equilibrium, or too little is left of it after the cut.
fn place(
    pore: &Pore,
    number: usize,
    objective: &Objective<'_>,
    options: &GuideOptions,
) -> Result<Option<GuideHair>, HairgenError> {
    let mut rod = GuideRod::new(&objective.flow.fitted(pore), number, options)?;
    let Some(found) = optimum(&mut rod, objective, options) else { return Ok(None) };
    let (terms, _) = objective.terms(&rod, &found.kept.shape);
    let curve = cut(found.kept.shape.positions(), objective.region, options.outside);
    let left: f64 = curve.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
    let guide = GuideHair {
        pore: number,
        load: EndLoad::of(&found.point),
        terms,
        value: found.value,
        equilibria: found.evaluations,
        curve,
        shape: found.kept.shape,
    };
    Ok((left >= options.least * pore.length).then_some(guide))
}

/// The objective as a function of the load on the end of a rod.
struct LoadSearch<'r, 'o> {
    rod: &'r mut GuideRod,
    objective: &'r Objective<'o>,
}

impl Searched for LoadSearch<'_, '_> {
    type Kept = Rest;

    fn at(&mut self, load: &Vector6<f64>, near: &Rest) -> Option<(f64, Vector6<f64>, Rest)> {
        self.objective.with_gradient(self.rod, load, &near.shape)
    }

    fn inverse_hessian(&self, rest: &Rest) -> Option<Matrix6<f64>> {
        self.objective.inverse_hessian(self.rod, rest)
    }
}

/// The end load that minimizes the objective, searched from that of the pre-guide next to the
/// guide.
fn optimum(
    rod: &mut GuideRod,
    objective: &Objective<'_>,
    options: &GuideOptions,
) -> Option<Minimum<Rest>> {
    let (load, rest) = objective.flow.start(rod)?;
    let mut search = LoadSearch { rod, objective };
    minimize(&mut search, &load.unknowns(), &rest, options.tolerance, options.equilibria)
}
