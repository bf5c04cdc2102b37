//! Hair that hangs, for pores whose hair is too long to be bent into the region by a force across.

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
const LEAST_PART: f64 = 0.02;

/// A hair of the pore's length that hangs by a force on its end.
struct HangingHair {
    load: EndLoad,
    shape: Shape,
    /// Arc length from the root on that stays in the region, m.
    reach: f64,
}

impl HangingHair {
    fn new(load: EndLoad, shape: Shape, region: Region<'_>, options: &GuideOptions) -> Self {
        let kept = cut(shape.positions(), region, options.outside);
        let reach = kept.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
        Self { load, shape, reach }
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
    region: Region<'_>,
    options: &GuideOptions,
) -> Result<HangingHairs, HairgenError> {
    let mut rod = GuideRod::new(pore, number, options)?;
    let unloaded = EndLoad { force: Vector3::zeros(), couple: Vector3::zeros() };
    let mut hairs = vec![HangingHair::new(unloaded, rod.straight(), region, options)];
    let mut force = WEAKEST;
    while force <= STRONGEST {
        let load = EndLoad { force: options.down.into_inner() * force, couple: Vector3::zeros() };
        let Ok(rest) = rod.relax(&load, &hairs[hairs.len() - 1].shape) else { break };
        hairs.push(HangingHair::new(load, rest.shape, region, options));
        force *= RATIO;
    }
    let mut all = HangingHairs { rod, hairs, best: 0 };
    // The weakest: its hair fills the hull.
    all.best = all.nearest(0, NEARLY);
    Ok(all)
}

impl HangingHairs {
    /// The number of the hair whose force is nearest to the force of a number, the weaker of two,
    /// of those that stay in the region for at least a part of the longest way.
    fn nearest(&self, force: usize, part: f64) -> usize {
        let longest = self.hairs.iter().map(|hair| hair.reach).fold(0.0, f64::max);
        let far = (0..self.hairs.len()).filter(|i| self.hairs[*i].reach >= part * longest);
        far.min_by_key(|i| i.abs_diff(force)).unwrap_or(0)
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
        let hair = &self.hairs[self.nearest(middle, ENOUGH)];
        shortened(pore, number, &self.rod, hair, options)
    }
}

/// The part of a hair that stays in the region, as a rod of its own: the load on its end is what
/// the rest of the hair bears there, so it has the same shape. It has no place if that is too
/// little, or no equilibrium.
fn shortened(
    pore: &Pore,
    number: usize,
    rod: &GuideRod,
    hair: &HangingHair,
    options: &GuideOptions,
) -> Result<PreGuide, HairgenError> {
    let hair_length = pore.length;
    let part = (hair.reach / hair_length).clamp(LEAST_PART, 1.0);
    let pore = Pore { length: part * hair_length, ..*pore };
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
    let placed = found.is_ok() && hair.reach >= options.least * hair_length;
    let (load, shape) = match found {
        Ok(rest) => (load, rest.shape),
        Err(_) => {
            let unloaded = EndLoad { force: Vector3::zeros(), couple: Vector3::zeros() };
            (unloaded, short.straight())
        }
    };
    let bends = short.bends(&shape);
    Ok(PreGuide { pore, shape, bends, load, placed })
}
