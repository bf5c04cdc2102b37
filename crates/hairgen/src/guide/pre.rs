use super::hang::{HangingHairs, hang};
use super::rod::{EndLoad, GuideRod};
use super::{GuideOptions, PreGuide};
use crate::error::choice;
use crate::near::nearest;
use crate::{HairgenError, Pore, Region};
use nalgebra::Vector3;
use rapunzel_rod_static::Shape;
use rayon::prelude::*;

/// First force on the end of a pre-guide, `EI / L^2`.
const FIRST_FORCE: f64 = 0.2;
/// Factor by which the force grows.
const GROWTH: f64 = 1.5;
/// Largest force: it bends the rod within a fortieth of its length.
const LARGEST_FORCE: f64 = 3000.0;
/// Number of halvings between the largest force that is too small and the smallest that is not.
const BISECTIONS: usize = 4;

/// Number of pores, one of them itself, among which a pre-guide hangs as most do.
const ALIKE: usize = 7;

/// The pre-guides of the `pores`, in their order.
///
/// `dips` says for each how deep it must go, from 0, just below the hull, to 1, at the head: the
/// depth below the hull over the sum of both distances. The force is dead and acts in the plane of
/// the scalp's normal and the growth direction, across that, toward the head. Hair that is longer
/// than the head is wide finds no place so, for it would wind about the head: it hangs by a force
/// downward, as far as it stays in the region, and ends there. The weakest force under which it
/// stays for the longest way, or nearly, fills the hull best, whatever the dip; of those of the
/// pores around that in the middle is taken, or the next one under which the hair stays for most of
/// its way.
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
    let all: Vec<Grown> =
        (0..pores.len()).into_par_iter().map(grow).collect::<Result<_, HairgenError>>()?;
    let hanging: Vec<(usize, &HangingHairs)> = (all.iter().enumerate())
        .filter_map(|(number, grown)| match grown {
            Grown::Bent(_) => None,
            Grown::Hanging(hairs) => Some((number, hairs)),
        })
        .collect();
    let finish = |(number, grown): (usize, &Grown)| match grown {
        Grown::Bent(guide) => Ok(guide.clone()),
        Grown::Hanging(hairs) => {
            let places = hanging.iter().map(|(number, _)| pores[*number].position);
            let near = nearest::<ALIKE, 3>(&pores[number].position, places);
            let around: Vec<_> = near.iter().map(|(_, i)| hanging[*i].1).collect();
            hairs.among(&around, &pores[number], number, options)
        }
    };
    all.par_iter().enumerate().map(finish).collect()
}

/// A pore with a pre-guide, or with those to choose from.
enum Grown {
    Bent(PreGuide),
    Hanging(HangingHairs),
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
) -> Result<Grown, HairgenError> {
    let mut rod = GuideRod::new(pore, number, options)?;
    let bend = rod.bend();
    let mut try_force = |force: f64, start: &Shape| {
        let load = EndLoad { force: bend * force, couple: Vector3::zeros() };
        let shape = rod.relax(&load, start).ok()?.shape;
        let lack = lacking(&shape, dip, region);
        Some(ForceTrial { load, shape, lack })
    };
    // The largest force that is too small, the one that lacks least, and the smallest that is
    // enough.
    let (mut low, mut force) = (0.0, FIRST_FORCE);
    let straight = GuideRod::new(pore, number, options)?.straight();
    let mut high = None;
    let mut best = ForceTrial::unloaded(straight, dip, region);
    let mut start = best.shape.clone();
    if best.lack != Some(0.0) {
        while force <= LARGEST_FORCE {
            let Some(attempt) = try_force(force, &start) else { break };
            if !attempt.is_between() {
                high = Some(force);
                best = best.better(attempt);
                break;
            }
            start.clone_from(&attempt.shape);
            best = best.better(attempt);
            (low, force) = (force, force * GROWTH);
        }
    }
    // Between a force that is too small and one that is enough, or presses it into the head.
    for _ in 0..BISECTIONS {
        let Some(above) = high else { break };
        let middle = 0.5 * (low + above);
        let Some(attempt) = try_force(middle, &start) else { break };
        if attempt.is_between() {
            low = middle;
        } else {
            high = Some(middle);
        }
        best = best.better(attempt);
    }
    if best.lack != Some(0.0) {
        return hang(pore, number, region, options).map(Grown::Hanging);
    }
    let bends = rod.bends(&best.shape);
    let load = best.load;
    Ok(Grown::Bent(PreGuide { pore: *pore, shape: best.shape, bends, load, placed: true }))
}

/// A shape of a pre-guide that is being grown.
struct ForceTrial {
    load: EndLoad,
    shape: Shape,
    /// As of [`lacking`].
    lack: Option<f64>,
}

impl ForceTrial {
    fn unloaded(shape: Shape, dip: f64, region: Region<'_>) -> Self {
        let load = EndLoad { force: Vector3::zeros(), couple: Vector3::zeros() };
        let lack = lacking(&shape, dip, region);
        Self { load, shape, lack }
    }

    /// Whether it is too shallow, but not in the head.
    fn is_between(&self) -> bool {
        self.lack.is_some_and(|lack| lack > 0.0)
    }

    /// The attempt of both that lacks less, `other` if both lack nothing.
    fn better(self, other: Self) -> Self {
        let rank = |attempt: &Self| attempt.lack.unwrap_or(f64::INFINITY);
        if other.lack.is_some() && rank(&other) <= rank(&self) { other } else { self }
    }
}

/// How much depth the shape lacks, m: zero if all its nodes are deep enough. `None` if a node
/// behind the root is in the head.
fn lacking(shape: &Shape, dip: f64, region: Region<'_>) -> Option<f64> {
    let mut lack = 0.0_f64;
    for position in &shape.positions()[1..] {
        let [inside, outside] = region.depths(position);
        if inside > 0.0 {
            return None;
        }
        lack = lack.max(outside + dip * (-inside - outside));
    }
    Some(lack)
}
