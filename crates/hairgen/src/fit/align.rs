//! The similarity between a template and a scan.

use super::similarity::Similarity;
use super::template::HeadTemplate;
use crate::HairgenError;
use nalgebra::{Point3, Rotation3, Unit, Vector3};
use rapunzel_collision::field::{Mesh, MeshDistance};
use rayon::prelude::*;

/// Sizes of a bust, m: the extent of a scan of a head, with or without shoulders.
const BUST: [f64; 2] = [0.12, 2.5];
/// Steps of the closest points.
const MOST_STEPS: usize = 150;
/// Part of the pairs of points that is kept: ornaments and hair over the face are left out.
const KEPT: f64 = 0.75;
/// Points of the face that are paired.
const SAMPLES: usize = 1500;
/// Angle from the hairline from which on a vertex counts as face, rad.
const BELOW_HAIRLINE: f64 = 0.12;
/// Steps from every start, with one of so many points.
const FIRST_STEPS: usize = 12;
const THINNED: usize = 6;
/// Depths of the hair over the vertex of the head from which the search starts, m.
const DEPTHS: [f64; 3] = [0.01, 0.03, 0.06];
/// Sizes of the head from which the search starts.
const SCALES: [f64; 3] = [0.9, 1.0, 1.1];
/// Half of the height of the face about the origin of the head, m.
const FACE: f64 = 0.07;
/// Change of a point in a step at which the search ends, m.
const STILL: f64 = 1e-5;

/// Meters for a unit of the scan: as given, or meters, centimeters or millimeters, by its size.
pub(super) fn unit(scan: &Mesh, given: Option<f64>) -> Result<f64, HairgenError> {
    let [low, high] = scan.bounds();
    let (size, [least, most]) = ((high - low).max(), BUST);
    let fits = |unit: &f64| (least..=most).contains(&(size * unit));
    match given {
        Some(unit) if fits(&unit) => Ok(unit),
        Some(unit) => Err(HairgenError::Size { what: "the scan", size: size * unit, least, most }),
        None => [1.0, 1e-2, 1e-3].into_iter().find(fits).ok_or(HairgenError::Units { size }),
    }
}

/// Vertices of the template's face, evenly thinned.
pub(super) fn face(template: &HeadTemplate) -> Vec<usize> {
    let lowest = 0.75 * template.mesh.vertices.iter().map(|p| p.y).fold(0.0, f64::min);
    let is_face = |p: &Point3<f64>| {
        let direction = Unit::try_new(p.coords, 0.0);
        p.z > 0.0
            && p.y > lowest
            && direction.is_some_and(|d| template.hairline.within(&d) < -BELOW_HAIRLINE)
    };
    let vertices = template.mesh.vertices.iter().enumerate();
    let all: Vec<usize> = vertices.filter(|(_, p)| is_face(p)).map(|(i, _)| i).collect();
    let step = all.len().div_ceil(SAMPLES).max(1);
    all.into_iter().step_by(step).collect()
}

/// The similarity from the template's face to the scan, and the root mean square of the distances
/// that are kept, m.
pub(super) fn align(
    hull: &Mesh,
    distance: &MeshDistance,
    template: &HeadTemplate,
    face: &[usize],
) -> Result<(Similarity, f64), HairgenError> {
    let thinned: Vec<usize> = face.iter().copied().step_by(THINNED).collect();
    let mut best: Option<(Similarity, f64)> = None;
    for start in outsets(hull, template) {
        let found = closest_points(distance, template, &thinned, start, FIRST_STEPS);
        if let Some(found) = found
            && best.is_none_or(|(_, rms)| found.1 < rms)
        {
            best = Some(found);
        }
    }
    let none = HairgenError::NoFace { rms: f64::INFINITY };
    let (start, _) = best.ok_or(none)?;
    let found = closest_points(distance, template, face, start, MOST_STEPS);
    let (best, rms) = found.ok_or(HairgenError::NoFace { rms: f64::INFINITY })?;
    // A face that is off by more than a nose is none.
    let close = rms < 0.015 && (0.5..=2.0).contains(&best.scale);
    if close { Ok((best, rms)) } else { Err(HairgenError::NoFace { rms }) }
}

/// The similarity to which the trimmed closest points lead from a start, and the root mean square
/// of the distances that are kept, m.
fn closest_points(
    distance: &MeshDistance,
    template: &HeadTemplate,
    face: &[usize],
    start: Similarity,
    steps: usize,
) -> Option<(Similarity, f64)> {
    let mut best = start;
    let mut rms = f64::INFINITY;
    for _ in 0..steps {
        let mut pairs: Vec<_> = face
            .par_iter()
            .map(|&i| {
                let from = template.mesh.vertices[i];
                let nearest = distance.tree().nearest(&best.apply(&from));
                (nearest.distance, [from, nearest.point])
            })
            .collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part")]
        pairs.truncate((KEPT * pairs.len() as f64) as usize);
        let squares: f64 = pairs.iter().map(|pair| pair.0 * pair.0).sum();
        rms = (squares / pairs.len().max(1) as f64).sqrt();
        let pairs: Vec<_> = pairs.into_iter().map(|pair| pair.1).collect();
        let next = Similarity::between(&pairs)?;
        let moved = |[from, _]: &[Point3<f64>; 2]| (next.apply(from) - best.apply(from)).norm();
        let change = pairs.iter().map(moved).fold(0.0, f64::max);
        best = next;
        if change < STILL {
            break;
        }
    }
    // In units of the head, or a head that shrinks to a point would be found everywhere.
    let rms = rms / best.scale;
    (rms.is_finite() && best.scale > 0.0).then_some((best, rms))
}

/// Starts: the head upright below hair of several depths, in several sizes, its face as far to the
/// front as the scan at this height.
fn outsets(hull: &Mesh, template: &HeadTemplate) -> Vec<Similarity> {
    let range = |points: &mut dyn Iterator<Item = &Point3<f64>>, axis: usize| {
        points.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| {
            [low.min(p[axis]), high.max(p[axis])]
        })
    };
    let face = |p: &&Point3<f64>| p.y.abs() < FACE;
    let [_, crown] = range(&mut template.mesh.vertices.iter(), 1);
    let [_, front] = range(&mut template.mesh.vertices.iter().filter(face), 2);
    let [_, top] = range(&mut hull.vertices().iter(), 1);
    let mut starts = Vec::new();
    for depth in DEPTHS {
        for scale in SCALES {
            let height = top - depth - scale * crown;
            let level = |p: &&Point3<f64>| (p.y - height).abs() < FACE * scale;
            let [left, right] = range(&mut hull.vertices().iter().filter(level), 0);
            let [_, seen] = range(&mut hull.vertices().iter().filter(level), 2);
            let translation = Vector3::new(0.5 * (left + right), height, seen - scale * front);
            if translation.iter().all(|x| x.is_finite()) {
                starts.push(Similarity { scale, rotation: Rotation3::identity(), translation });
            }
        }
    }
    starts
}
