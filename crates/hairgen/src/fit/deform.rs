//! The smooth deformation that lays the face on the scan and the skull below the hair.

use super::similarity::Similarity;
use super::template::{FitOptions, HeadTemplate};
use crate::HairgenError;
use nalgebra::{DMatrix, Point3, Unit, Vector3};
use rapunzel_collision::field::{DistanceField, MeshDistance, Soup};
use rapunzel_linalg::SparseSystem;
use rayon::prelude::*;

/// Length over which the deformation is smooth, m.
const SMOOTH: f64 = 12e-3;
/// Farthest a vertex of the face is pulled to the scan, m: beyond there is something on the face.
const PULLED: f64 = 10e-3;
/// Rounds in which vertices of the skull that stand out are pushed in.
const ROUNDS: usize = 10;
/// Angle over which the margin grows from nothing at the hairline, rad.
const RIM: f64 = 0.3;
/// Weight of the head's vertices that are free, against those that are pulled.
const FREE: f64 = 1e-4;

pub(super) struct Deformed {
    pub(super) head: Soup,
    pub(super) rms: f64,
    pub(super) largest: f64,
}

/// Where a vertex is wanted: displacement along its ray, m, and weight.
#[derive(Clone, Copy)]
struct Wanted {
    displacement: f64,
    weight: f64,
}

pub(super) fn deform(
    distance: &MeshDistance,
    template: &HeadTemplate,
    face: &[usize],
    similarity: &Similarity,
    options: &FitOptions,
) -> Result<Deformed, HairgenError> {
    let start: Vec<_> = template.mesh.vertices.iter().map(|p| similarity.apply(p)).collect();
    let origin = similarity.apply(&Point3::origin());
    let rays: Vec<_> = start.iter().map(|p| Unit::try_new(p - origin, 0.0)).collect();
    let rays: Vec<_> = rays.into_iter().map(|ray| ray.unwrap_or_else(Vector3::y_axis)).collect();
    let at = |i: usize, u: f64| start[i] + rays[i].into_inner() * u;
    let mut wanted = vec![Wanted { displacement: 0.0, weight: FREE }; start.len()];
    for &i in face {
        let sample = distance.sample(&start[i]);
        let facing = sample.gradient.dot(&rays[i]);
        // On the scan: along the ray by the distance over the cosine.
        if sample.value.abs() < PULLED && facing > 0.3 {
            wanted[i] = Wanted { displacement: -sample.value / facing, weight: 1.0 };
        }
    }
    let margin = |vertex| margin(vertex, template, options);
    let margin: Vec<_> = template.mesh.vertices.iter().map(margin).collect();
    let squared = squared_laplacian(&template.mesh, similarity.scale);
    let mut displacement = vec![0.0; start.len()];
    for _ in 0..ROUNDS {
        displacement = smooth(&squared, &wanted)?;
        // Where a vertex that stands out is wanted instead.
        let pushed = |i: usize| {
            let sample = distance.sample(&at(i, displacement[i]));
            let above = sample.value + margin[i]?;
            let facing = sample.gradient.dot(&rays[i]).max(0.3);
            (above > 0.0).then_some(displacement[i] - 1.2 * above / facing)
        };
        let pushed: Vec<_> = (0..start.len()).into_par_iter().map(pushed).collect();
        if pushed.iter().all(Option::is_none) {
            break;
        }
        for (wanted, pushed) in wanted.iter_mut().zip(pushed) {
            if let Some(displacement) = pushed {
                *wanted = Wanted { displacement, weight: 1.0 };
            }
        }
    }
    // What still stands out after the last round is pushed in by itself.
    let settled = |i: usize| {
        let mut displacement = displacement[i];
        let Some(margin) = margin[i] else { return displacement };
        for _ in 0..20 {
            let above = distance.value(&at(i, displacement)) + margin;
            if above <= 0.0 {
                break;
            }
            displacement -= above.max(1e-5);
        }
        displacement
    };
    let displacement: Vec<_> = (0..start.len()).into_par_iter().map(settled).collect();
    let vertices: Vec<_> = (0..start.len()).map(|i| at(i, displacement[i])).collect();
    let near = face.iter().filter(|&&i| wanted[i].weight == 1.0);
    let squares: Vec<_> = near.map(|&i| distance.value(&vertices[i]).powi(2)).collect();
    let rms = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
    let largest = displacement.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
    let head = Soup { vertices, triangles: template.mesh.triangles.clone() };
    Ok(Deformed { head, rms, largest })
}

/// How deep a vertex of the skull must lie under the scan, m; `None` outside of the hairline.
fn margin(vertex: &Point3<f64>, template: &HeadTemplate, options: &FitOptions) -> Option<f64> {
    let direction = Unit::try_new(vertex.coords, 0.0)?;
    let within = template.hairline.within(&direction) / RIM;
    (within > 0.0).then(|| {
        let t = within.min(1.0);
        options.margin * t * t * (3.0 - 2.0 * t)
    })
}

/// Entries of the squared Laplacian of a mesh in units in which [`SMOOTH`] is 1, on the mean edge.
fn squared_laplacian(mesh: &Soup, scale: f64) -> Vec<(usize, usize, f64)> {
    let count = mesh.vertices.len();
    let mut neighbors = vec![Vec::new(); count];
    let (mut sum, mut sides) = (0.0, 0.0);
    for triangle in &mesh.triangles {
        for k in 0..3 {
            let [a, b] = [triangle[k] as usize, triangle[(k + 1) % 3] as usize];
            neighbors[a].push(b);
            sum += (mesh.vertices[a] - mesh.vertices[b]).norm() * scale;
            sides += 1.0;
        }
    }
    let ratio = SMOOTH * sides / sum;
    let mut squared = Vec::new();
    // Each row `u_i - mean of neighbors`, times (length / edge)^2, squared by `L^T L`.
    for (i, neighbors) in neighbors.iter().enumerate().filter(|(_, n)| !n.is_empty()) {
        let part = -1.0 / neighbors.len() as f64;
        let row: Vec<_> =
            std::iter::once((i, 1.0)).chain(neighbors.iter().map(|&j| (j, part))).collect();
        for &(a, x) in &row {
            squared.extend(row.iter().map(|&(b, y)| (a, b, ratio.powi(4) * x * y)));
        }
    }
    squared
}

/// The displacements that are near what is wanted and smooth: `(W + L^T L) u = W t`.
fn smooth(squared: &[(usize, usize, f64)], wanted: &[Wanted]) -> Result<Vec<f64>, HairgenError> {
    let mut entries = squared.to_vec();
    entries.extend(wanted.iter().enumerate().map(|(i, w)| (i, i, w.weight)));
    let right = DMatrix::from_fn(wanted.len(), 1, |i, _| wanted[i].weight * wanted[i].displacement);
    let system = SparseSystem::positive_definite(wanted.len(), &entries)?;
    Ok(system.solve(&right)?.column(0).iter().copied().collect())
}
