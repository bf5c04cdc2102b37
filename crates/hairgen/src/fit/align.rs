//! The similarity between a template and a scan.

use super::{HeadTemplate, Similarity};
use crate::HairgenError;
use nalgebra::{Point3, Rotation3, Unit, Vector3};
use rapunzel_collision::field::{Mesh, MeshDistance};

/// Sizes of a bust, m: the extent of a scan of a head, with or without shoulders.
const BUST: [f64; 2] = [0.12, 2.5];
/// Steps of the closest points.
const MOST_STEPS: usize = 80;
/// Part of the pairs of points that is kept: ornaments and hair over the face are left out.
const KEPT: f64 = 0.75;
/// Points of the face that are paired.
const SAMPLES: usize = 1500;
/// Angle from the hairline from which on a vertex counts as face, rad.
const BELOW_HAIRLINE: f64 = 0.12;
/// Depth of the hair over the vertex of the head from which the search starts, m.
const CROWN: f64 = 0.015;
/// Change of a point in a step at which the search ends, m.
const STILL: f64 = 1e-7;

/// Meters for a unit of the scan: meters, centimeters or millimeters, by its size.
pub(super) fn unit(scan: &Mesh) -> Result<f64, HairgenError> {
    let [low, high] = scan.bounds();
    let size = (high - low).max();
    let fits = |unit: &f64| (BUST[0]..=BUST[1]).contains(&(size * unit));
    [1.0, 1e-2, 1e-3].into_iter().find(fits).ok_or(HairgenError::Units { size })
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
    let mut best = outset(hull, template);
    let mut rms = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let mut pairs: Vec<_> = face
            .iter()
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
        let next = Similarity::between(&pairs).ok_or(HairgenError::NoFace { rms })?;
        let moved = |[from, _]: &[Point3<f64>; 2]| (next.apply(from) - best.apply(from)).norm();
        let change = pairs.iter().map(moved).fold(0.0, f64::max);
        best = next;
        if change < STILL {
            break;
        }
    }
    // A face that is off by more than a nose is none.
    let close = rms < 0.015 && (0.5..=2.0).contains(&best.scale);
    if close { Ok((best, rms)) } else { Err(HairgenError::NoFace { rms }) }
}

/// A first guess: vertex on vertex with some hair between, nose on what stands out most below.
fn outset(hull: &Mesh, template: &HeadTemplate) -> Similarity {
    let highest = |points: &[Point3<f64>]| points.iter().map(|p| p.y).fold(f64::MIN, f64::max);
    let nose = |points: &[Point3<f64>], top: f64, scale: f64| {
        let below = points.iter().filter(|p| (0.08..0.20).contains(&((top - p.y) / scale)));
        below.copied().max_by(|a, b| a.z.total_cmp(&b.z))
    };
    let crown = highest(&template.mesh.vertices);
    let top = highest(hull.vertices());
    let own = nose(&template.mesh.vertices, crown, 1.0).unwrap_or_else(Point3::origin);
    let seen = nose(hull.vertices(), top, 1.0).unwrap_or_else(Point3::origin);
    let height = top - CROWN - crown;
    Similarity {
        scale: 1.0,
        rotation: Rotation3::identity(),
        translation: Vector3::new(seen.x - own.x, height, seen.z - own.z),
    }
}
