use super::curves::HairCurves;
use super::line::{GuideLine, length, resample};
use super::options::{HairOptions, HairPattern};
use super::rein::rein;
use crate::guide::GuideHair;
use crate::near::nearest;
use crate::{HairgenError, Pore, Region, cut};
use nalgebra::{Point3, Rotation3, Vector3};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Number of hairs that a thread lays at once.
const CHUNK: usize = 256;
/// Number of guides that a hair between guides is a mean of, and one more, at which weights vanish.
const FOLLOWED: usize = 4;

/// A hair in each of the `pores`, in their order, along the `guides`, which grow out of
/// `guide_pores`.
///
/// A hair is as long as its guides, and no longer than its pore says. Its segments are of equal
/// length; where it would enter the head or leave the hull it is led along them, and where that
/// fails it is cut (see [`cut`](crate::cut())). Cost: in proportion to the hairs, and 1 ns for each
/// hair and guide for the nearest ones.
///
/// # Errors
/// Options out of range, no guides, a guide with a pore that is not there, and pores whose position
/// or length is not finite.
pub fn grow_hairs(
    pores: &[Pore],
    guides: &[GuideHair],
    guide_pores: &[Pore],
    region: Region<'_>,
    options: &HairOptions,
) -> Result<HairCurves, HairgenError> {
    options.validate()?;
    if guides.is_empty() {
        let remedy = "lay some; all those laid may have found no place";
        return Err(HairgenError::Nothing { what: "guides", remedy });
    }
    for (number, pore) in pores.iter().enumerate() {
        let fine = pore
            .position
            .iter()
            .chain(pore.disc.iter())
            .chain([&pore.length])
            .all(|x| x.is_finite());
        if !fine || pore.length < 0.0 {
            let problem = "its places and its length must be finite, and the length not negative";
            return Err(HairgenError::Pore { pore: number, problem });
        }
    }
    let field = GuideField::new(guides, guide_pores, options)?;
    let parts: Vec<HairCurves> = pores
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(part, chunk)| {
            let mut curves = HairCurves::default();
            let mut buffers = <[Vec<Point3<f64>>; 3]>::default();
            for (i, pore) in chunk.iter().enumerate() {
                let number = part * CHUNK + i;
                curves.push(&field.hair(pore, number, region, options, &mut buffers));
            }
            curves
        })
        .collect();
    Ok(HairCurves::joined(&parts))
}

/// The guides, as hairs follow them.
struct GuideField {
    lines: Vec<GuideLine>,
    /// Pores of the guides, in their order.
    pores: Vec<Pore>,
}

impl GuideField {
    fn new(
        guides: &[GuideHair],
        pores: &[Pore],
        options: &HairOptions,
    ) -> Result<Self, HairgenError> {
        let pore = |guide: &GuideHair| {
            let problem =
                "a guide grows out of it, but it is not there; give the guides' own pores";
            pores.get(guide.pore).copied().ok_or(HairgenError::Pore { pore: guide.pore, problem })
        };
        let line = |guide: &GuideHair| GuideLine::new(&guide.curve, options.segments);
        Ok(Self {
            lines: guides.par_iter().map(line).collect(),
            pores: guides.iter().map(pore).collect::<Result<_, _>>()?,
        })
    }

    /// The hair of pore number `number`; empty if nothing is left of it.
    fn hair(
        &self,
        pore: &Pore,
        number: usize,
        region: Region<'_>,
        options: &HairOptions,
        [way, aims, hair]: &mut [Vec<Point3<f64>>; 3],
    ) -> Vec<Point3<f64>> {
        match options.pattern {
            HairPattern::Wisps { tip, turns } => self.in_wisp(pore, tip, turns, way),
            HairPattern::Between => self.between(pore, way),
        }
        if let Some(curl) = &options.curl {
            curl.wind(way, &pore.normal, number);
        }
        let length = length(way).min(pore.length);
        if length <= 0.0 {
            return Vec::new();
        }
        resample(way, length, options.segments, aims);
        let segment = length / options.segments as f64;
        rein(&pore.position, aims, segment, region, options.clearance, hair);
        let kept = cut(hair, region, options.outside);
        if kept.len() > 1 { kept } else { Vec::new() }
    }

    /// The way of a hair in the wisp of the guide with the nearest root.
    fn in_wisp(&self, pore: &Pore, tip: f64, turns: f64, way: &mut Vec<Point3<f64>>) {
        let near = nearest::<1, 3>(&pore.position, self.pores.iter().map(|pore| pore.position));
        let line = &self.lines[near[0].1];
        way.clear();
        // The place of the root in the axes of the guide's root; what it is off along the guide
        // vanishes toward the tip.
        let off = line.frames[0].inverse_transform_vector(&(pore.position - line.points[0]));
        let last = line.points.len() - 1;
        for (node, (point, frame)) in line.points.iter().zip(&line.frames).enumerate() {
            let part = node as f64 / last as f64;
            let radius = 1.0 + (tip - 1.0) * part;
            let across = Vector3::new(off.x, off.y, 0.0) * radius;
            let wound = Rotation3::from_axis_angle(&Vector3::z_axis(), TAU * turns * part) * across;
            let along = Vector3::z() * (off.z * (1.0 - part) * (1.0 - part));
            way.push(point + frame * (wound + along));
        }
    }

    /// The way of a hair that is the mean of three guides, each moved to its root. The weights are
    /// continuous: they vanish at the distance of the fourth guide (Franke and Little's weights,
    /// Franke 1982).
    fn between(&self, pore: &Pore, way: &mut Vec<Point3<f64>>) {
        let near = nearest::<FOLLOWED, 2>(&pore.disc, self.pores.iter().map(|pore| pore.disc));
        let limit = near.get(FOLLOWED - 1).map_or(f64::INFINITY, |(distance, _)| *distance);
        let count = near.len().min(FOLLOWED - 1);
        // A hair in the pore of a guide follows that alone.
        let weight = |distance: f64| (1.0 / distance.max(1e-9) - 1.0 / limit.max(1e-9)).powi(2);
        let sum: f64 = near[..count].iter().map(|(distance, _)| weight(*distance)).sum();
        // All four as far: all three count alike.
        let share = |distance: f64| {
            if sum > 0.0 { weight(distance) / sum } else { (count as f64).recip() }
        };
        way.clear();
        way.resize(self.lines[0].points.len(), pore.position);
        for (distance, guide) in &near[..count] {
            let (part, points) = (share(*distance), &self.lines[*guide].points);
            for (at, point) in way.iter_mut().zip(points) {
                *at += (point - points[0]) * part;
            }
        }
    }
}
