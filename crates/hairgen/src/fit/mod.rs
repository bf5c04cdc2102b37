//! From one scan of a head with its hair to what a hairstyle grows from: the bald head below, the
//! surface of the hair and the scalp within the hairline. The thesis takes this as given (5.3).

mod align;
mod cut;
mod deform;
mod similarity;

pub use similarity::Similarity;

use crate::HairgenError;
use crate::head::{Hairline, ParametricHead};
use nalgebra::{Point3, Unit, Vector3};
use rapunzel_collision::field::{DistanceField, Mesh, MeshDistance, Soup};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A bald head that is fitted to scans: y up, the face along z, the origin within the head between
/// the ears, meters.
#[derive(Debug, Clone, PartialEq)]
pub struct HeadTemplate {
    /// Its closed surface, seen whole from the origin but for what is small.
    pub mesh: Soup,
    /// The rim of its scalp.
    pub hairline: Hairline,
}

impl From<&ParametricHead> for HeadTemplate {
    fn from(head: &ParametricHead) -> Self {
        Self { mesh: head.mesh(), hairline: head.hairline().clone() }
    }
}

/// How a head is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FitOptions {
    /// Meters for a unit of the scan; found from its size where it is left out.
    pub meters_per_unit: Option<f64>,
    /// Least depth of the skull under the surface of the hair, m, away from the hairline.
    pub margin: f64,
    /// Depth of hair from which on the surface counts as hair, m.
    pub threshold: f64,
    /// Whether hair hangs below the chin.
    pub hanging: bool,
    /// Sectors of the scalp's triangles about its middle.
    pub sectors: u32,
    /// Rings of the scalp's triangles.
    pub rings: u32,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            meters_per_unit: None,
            margin: 5e-3,
            threshold: 2e-3,
            hanging: false,
            sectors: 120,
            rings: 40,
        }
    }
}

/// How well a head was fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct FitReport {
    /// Meters for a unit of the scan.
    pub meters_per_unit: f64,
    /// From the template to the scan, in meters.
    pub similarity: Similarity,
    /// Root mean square of the distances of the face after the similarity, m: of the nearest three
    /// quarters.
    pub rms: f64,
    /// Root mean square of the distances of the face after the smooth deformation, m.
    pub deformed_rms: f64,
    /// Largest way of a vertex in the deformation, m.
    pub deformation: f64,
    /// Least and largest depth of the scalp under the surface of the hair, m.
    pub depth: [f64; 2],
}

impl fmt::Display for FitReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "a unit is {} m; head scaled by {:.3}; face off by {:.1} mm, then {:.1} mm; head bent by \
             up to {:.1} mm; hair {:.1} to {:.1} mm deep",
            self.meters_per_unit,
            self.similarity.scale,
            1e3 * self.rms,
            1e3 * self.deformed_rms,
            1e3 * self.deformation,
            1e3 * self.depth[0],
            1e3 * self.depth[1],
        )
    }
}

/// A scan taken apart, in meters, in the frame of the scan.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedHead {
    /// The scan in meters: the surface of head and hair together.
    pub hull: Mesh,
    /// The closed surface of the bald head.
    pub head: Soup,
    /// The part of the head where hair grows: a disc of triangles.
    pub scalp: Soup,
    /// The part of the scan that is hair.
    pub hair_surface: Soup,
    /// What was found.
    pub report: FitReport,
}

/// Takes a scan of a head with hair apart.
///
/// The template is brought to the face by a similarity (trimmed closest points), then bent smoothly
/// so that the face lies on the scan and the skull lies below it everywhere (least squares with the
/// squared Laplacian). Cost: some seconds for 80,000 triangles.
///
/// # Errors
/// [`HairgenError::Units`] of a scan that is no head in any unit, [`HairgenError::NoFace`] where
/// the template finds no face, [`HairgenError::Surface`] and those of the deformation's equations.
pub fn fit(
    scan: &Mesh,
    template: &HeadTemplate,
    options: &FitOptions,
) -> Result<FittedHead, HairgenError> {
    template.hairline.check()?;
    let unit = match options.meters_per_unit {
        Some(unit) => unit,
        None => align::unit(scan)?,
    };
    let scaled = Soup {
        vertices: scan.vertices().iter().map(|p| p * unit).collect(),
        triangles: scan.triangles().to_vec(),
    };
    let surface = |source| HairgenError::Surface { what: "the scan", source };
    let hull = Mesh::new(scaled).map_err(surface)?;
    let distance = MeshDistance::new(&hull);
    let face = align::face(template);
    let (similarity, rms) = align::align(&hull, &distance, template, &face)?;
    let deformed = deform::deform(&distance, template, &face, &similarity, options)?;
    let surface = |source| HairgenError::Surface { what: "the fitted head", source };
    let head = Mesh::new(deformed.head.clone()).map_err(surface)?;
    let bald = MeshDistance::new(&head);
    let view = View { head: &bald, similarity: &similarity };
    let hair_surface = cut::hair_surface(&hull, &view, &template.hairline, options);
    let scalp = cut::scalp(&distance, &view, &template.hairline, options)?;
    let depths = scalp.vertices.iter().map(|p| -distance.value(p));
    let depth =
        depths.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], d| [low.min(d), high.max(d)]);
    let report = FitReport {
        meters_per_unit: unit,
        similarity,
        rms,
        deformed_rms: deformed.rms,
        deformation: deformed.largest,
        depth,
    };
    Ok(FittedHead { hull, head: deformed.head, scalp, hair_surface, report })
}

/// The fitted head as the template's origin sees it.
struct View<'a> {
    head: &'a MeshDistance,
    similarity: &'a Similarity,
}

/// Farthest a head reaches from its origin, m, before the similarity.
const REACH: f64 = 0.3;

impl View<'_> {
    /// The outermost place of the head along a direction of the template's frame.
    fn place(&self, direction: &Unit<Vector3<f64>>) -> Point3<f64> {
        let outward = self.similarity.rotation * direction.into_inner();
        let origin = self.similarity.apply(&Point3::origin());
        let mut far = REACH * self.similarity.scale;
        // The distance is a way on which nothing is met.
        for _ in 0..200 {
            let free = self.head.value(&(origin + outward * far));
            far -= free;
            if free < 1e-9 || far <= 0.0 {
                break;
            }
        }
        origin + outward * far.max(0.0)
    }

    /// The direction in the template's frame in which a point lies.
    fn direction(&self, point: &Point3<f64>) -> Option<Unit<Vector3<f64>>> {
        let origin = self.similarity.apply(&Point3::origin());
        let way = self.similarity.rotation.inverse() * (point - origin);
        Unit::try_new(way, 0.0)
    }
}
