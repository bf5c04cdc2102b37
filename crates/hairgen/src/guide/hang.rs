//! Hair that hangs, for pores whose hair is too long to be bent into the region by a force across.

use super::pre::shortfall;
use super::rod::{EndLoad, GuideRod};
use super::{GuideOptions, PreGuide};
use crate::{HairgenError, Pore, Region, cut};
use nalgebra::Vector3;
use rapunzel_rod_static::Shape;

/// Forces downward on the end that are tried, `EI / L^2`: the first, their ratio and the last. The
/// last one turns a hair downward within a twentieth of its length.
const WEAKEST: f64 = 2.0;
const RATIO: f64 = 1.6;
const STRONGEST: f64 = 700.0;
/// Part of the longest way in the region that is as good as all of it.
const NEARLY: f64 = 0.98;
/// Part of the longest way for which a hair is let hang like those around it.
const ENOUGH: f64 = 0.8;
/// Shortest part of a pore's length that is laid at all.
const SHORTEST: f64 = 0.02;

/// A hair of the pore's length that hangs by a force on its end.
struct HangingHair {
    load: EndLoad,
    shape: Shape,
    /// Arc length from the root on that stays in the region, m.
    reach: f64,
    /// How far this part is from the depth asked for in the mean, m.
    off: f64,
}

impl HangingHair {
    fn new(
        load: EndLoad,
        shape: Shape,
        dip: f64,
        region: Region<'_>,
        options: &GuideOptions,
    ) -> Self {
        let kept = cut(shape.positions(), region, options.outside);
        let reach = kept.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
        let off = kept.iter().map(|point| shortfall(region.depths(point), dip).abs());
        let off = off.sum::<f64>() / kept.len().max(1) as f64;
        Self { load, shape, reach, off }
    }
}

/// The hairs of a pore under the forces, from none on.
pub(super) struct HangingHairs {
    rod: GuideRod,
    hairs: Vec<HangingHair>,
    /// Number of the one that fits best by itself.
    best: usize,
}

/// Hangs a hair of the pore by each of the forces.
pub(super) fn hang(
    pore: &Pore,
    number: usize,
    dip: f64,
    region: Region<'_>,
    options: &GuideOptions,
) -> Result<HangingHairs, HairgenError> {
    let mut rod = GuideRod::new(pore, number, options)?;
    let unloaded = EndLoad { force: Vector3::zeros(), couple: Vector3::zeros() };
    let mut hairs = vec![HangingHair::new(unloaded, rod.straight(), dip, region, options)];
    let mut force = WEAKEST;
    while force <= STRONGEST {
        let load = EndLoad { force: options.down.into_inner() * force, couple: Vector3::zeros() };
        let Ok(rest) = rod.relax(&load, &hairs[hairs.len() - 1].shape) else { break };
        hairs.push(HangingHair::new(load, rest.shape, dip, region, options));
        force *= RATIO;
    }
    let mut all = HangingHairs { rod, hairs, best: 0 };
    all.best = all.least(NEARLY, |_, hair| hair.off);
    Ok(all)
}

impl HangingHairs {
    /// The number of the hair for which `cost` is least, the first of several, of those that stay
    /// in the region for a part of the longest way.
    fn least(&self, part: f64, cost: impl Fn(usize, &HangingHair) -> f64) -> usize {
        let longest = self.hairs.iter().map(|hair| hair.reach).fold(0.0, f64::max);
        let far = self.hairs.iter().enumerate().filter(|(_, hair)| hair.reach >= part * longest);
        let ranked = far.map(|(number, hair)| (cost(number, hair), number));
        ranked.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, number)| number)
    }

    /// The pre-guide of the pore, by about the force by which most of the pores around hang, so
    /// that hair next to each other hangs alike; it ends where it leaves the region.
    pub(super) fn among(
        &self,
        around: &[&Self],
        pore: &Pore,
        number: usize,
        options: &GuideOptions,
    ) -> Result<PreGuide, HairgenError> {
        let mut forces: Vec<usize> = around.iter().map(|other| other.best).collect();
        forces.sort_unstable();
        let middle = forces.get(forces.len() / 2).copied().unwrap_or(self.best);
        let hair = &self.hairs[self.least(ENOUGH, |force, _| force.abs_diff(middle) as f64)];
        let placed = hair.reach >= options.least * pore.length;
        shortened(pore, number, &self.rod, hair, options).map(|guide| PreGuide { placed, ..guide })
    }
}

/// The part of a hair that stays in the region, as a rod of its own: the load on its end is what
/// the rest of the hair bears there, so it has the same shape.
fn shortened(
    pore: &Pore,
    number: usize,
    rod: &GuideRod,
    hair: &HangingHair,
    options: &GuideOptions,
) -> Result<PreGuide, HairgenError> {
    let part = (hair.reach / pore.length).clamp(SHORTEST, 1.0);
    let pore = Pore { length: part * pore.length, ..*pore };
    let mut short = GuideRod::new(&pore, number, options)?;
    let frames = hair.shape.frames();
    let last = frames.len() - 1;
    let frame = |node: usize| {
        let at = part * node as f64;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a node")]
        let before = (at as usize).min(last - 1);
        frames[before].slerp(&frames[before + 1], at - before as f64)
    };
    let start = short.shape_of((0..=last).map(frame).collect());
    let bends = rod.bends(&hair.shape);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a segment")]
    let end = ((part * last as f64).ceil() as usize).clamp(1, last) - 1;
    // In units of the shorter rod.
    let moment = bends[end].component_mul(&Vector3::new(1.0, 1.0, options.torsion)) * part;
    let couple = if part < 1.0 { moment } else { hair.load.couple };
    let load = EndLoad { force: hair.load.force * (part * part), couple };
    let found = start.and_then(|start| short.relax(&load, &start));
    let (load, shape) = match found {
        Ok(rest) => (load, rest.shape),
        Err(_) => {
            let unloaded = EndLoad { force: Vector3::zeros(), couple: Vector3::zeros() };
            (unloaded, short.straight())
        }
    };
    let bends = short.bends(&shape);
    Ok(PreGuide { pore, shape, bends, load, placed: false })
}
