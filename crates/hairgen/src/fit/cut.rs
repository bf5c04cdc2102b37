//! The surface of the hair and the scalp, cut out of a scan and of the head fitted to it.

use super::template::FitOptions;
use super::view::FittedView;
use crate::HairgenError;
use crate::head::Hairline;
use rapunzel_collision::field::{DistanceField, Mesh, MeshDistance, Soup};
use rayon::prelude::*;

/// Height of the chin in the template's frame over which hair is looked for, m, where none hangs.
const CHIN: f64 = -0.115;
/// How far before the hairline the surface may still be hair that falls over the forehead, rad.
const FRINGE: f64 = 0.35;
/// Growth of the depth from which on the surface counts as hair with the angle below the hairline,
/// m/rad: what lies on bare skin there, off by the error of the fit, are ears and the neck.
const DEPTH_BELOW: f64 = 0.012;
/// Least part of the way from the middle of the scalp to the hairline on which hair grows.
const LEAST: f64 = 0.5;

/// The triangles of the scan that are hair: farther from the head than a threshold, connected with
/// what is over the middle of the scalp, and not in the face.
pub(super) fn hair_surface(
    hull: &Mesh,
    view: &FittedView<'_>,
    hairline: &Hairline,
    options: &FitOptions,
) -> Soup {
    let corners = |t: &[u32; 3]| t.map(|v| hull.vertices()[v as usize]);
    let lowest = view.similarity.scale * CHIN;
    let triangles = hull.triangles();
    let is_hair: Vec<bool> = triangles
        .par_iter()
        .map(|triangle| {
            let [a, b, c] = corners(triangle);
            let middle = nalgebra::Point3::from((a.coords + b.coords + c.coords) / 3.0);
            let Some(direction) = view.direction(&middle) else { return false };
            let origin = view.similarity.translation;
            let height = (view.similarity.rotation.inverse() * (middle.coords - origin)).y;
            let below = (-hairline.within(&direction)).max(0.0);
            let in_face = direction.z > 0.0 && below > FRINGE;
            (options.hanging || height > lowest)
                && !in_face
                && view.head.value(&middle) > options.threshold + DEPTH_BELOW * below
        })
        .collect();
    // The part that is connected with what is seen over the middle of the scalp.
    let mut known = vec![false; triangles.len()];
    let crown = view.place(&hairline.axis());
    let start = (0..triangles.len()).filter(|&t| is_hair[t]).min_by(|&a, &b| {
        let off = |t: usize| (corners(&triangles[t])[0] - crown).norm_squared();
        off(a).total_cmp(&off(b))
    });
    let mut around = vec![Vec::new(); hull.vertices().len()];
    for (t, triangle) in triangles.iter().enumerate() {
        triangle.iter().for_each(|&v| around[v as usize].push(t));
    }
    let mut front: Vec<usize> = start.into_iter().collect();
    while let Some(t) = front.pop() {
        if !std::mem::replace(&mut known[t], true) {
            let next = triangles[t].iter().flat_map(|&v| &around[v as usize]);
            front.extend(next.filter(|&&n| is_hair[n] && !known[n]));
        }
    }
    let kept = triangles.iter().zip(&known).filter(|(_, known)| **known).map(|(t, _)| *t);
    compact(hull, kept.collect())
}

/// Some triangles of a mesh, with their own vertices only.
fn compact(mesh: &Mesh, mut triangles: Vec<[u32; 3]>) -> Soup {
    let mut names = vec![u32::MAX; mesh.vertices().len()];
    let mut vertices = Vec::new();
    for corner in triangles.iter_mut().flatten() {
        let name = &mut names[*corner as usize];
        if *name == u32::MAX {
            *name = u32::try_from(vertices.len()).unwrap_or(u32::MAX);
            vertices.push(mesh.vertices()[*corner as usize]);
        }
        *corner = *name;
    }
    Soup { vertices, triangles }
}

/// The scalp: within the hairline, and as far from its middle as the scan shows hair.
pub(super) fn scalp(
    distance: &MeshDistance,
    view: &FittedView<'_>,
    hairline: &Hairline,
    options: &FitOptions,
) -> Result<Soup, HairgenError> {
    let whole = hairline.disc(options.sectors, options.rings, |d| view.place(d))?;
    let deep =
        |vertex: u32| -distance.value(&whole.vertices[vertex as usize]) > 0.5 * options.threshold;
    let reach = |sector: u32| {
        let vertex = |ring: u32| 1 + (ring - 1) * options.sectors + sector;
        let bare = (1..=options.rings).find(|&ring| {
            f64::from(ring) >= LEAST * f64::from(options.rings) && !deep(vertex(ring))
        });
        bare.map_or(1.0, |ring| f64::from(ring - 1) / f64::from(options.rings))
    };
    let reached: Vec<f64> = (0..options.sectors).map(reach).collect();
    // The mean over a few sectors: a hairline has no teeth.
    let count = reached.len();
    let smooth = |about: f64| {
        let at = about / std::f64::consts::TAU * count as f64;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative")]
        let sector = at.round() as usize;
        (0..7).map(|k| reached[(sector + count + k - 3) % count]).sum::<f64>() / 7.0
    };
    hairline.disc_to(options.sectors, options.rings, smooth, |d| view.place(d))
}
