use super::similarity::Similarity;
use super::template::{FitOptions, FitReport, FittedHead, HeadTemplate};
use super::view::FittedView;
use super::{align, cut, deform};
use crate::HairgenError;
use crate::head::Hairline;
use rapunzel_collision::field::{DistanceField, Mesh, MeshDistance, Soup};

/// Takes a scan of a head with hair apart.
///
/// The template is brought to the face by a similarity (trimmed closest points), then bent smoothly
/// so that the face lies on the scan and the skull lies below it everywhere (least squares with the
/// squared Laplacian). Cost: some seconds for 80,000 triangles.
///
/// # Errors
/// [`HairgenError::Choice`] of options, [`HairgenError::Units`] and [`HairgenError::Size`] of a
/// scan that is no head in any unit or the one that is given, [`HairgenError::NoFace`] where the
/// template finds no face, [`HairgenError::Surface`] and those of the deformation's equations.
pub fn fit(
    scan: &Mesh,
    template: &HeadTemplate,
    options: &FitOptions,
) -> Result<FittedHead, HairgenError> {
    options.validate()?;
    let unit = align::unit(scan, options.meters_per_unit)?;
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
    let view = FittedView { head: &bald, similarity: &similarity };
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

/// The part of a bald head within the hairline, a disc of triangles: `sectors` about its middle and
/// `rings`. The head stands as a [`HeadTemplate`] does.
///
/// # Errors
/// [`HairgenError::Resolution`].
pub fn scalp_of(
    head: &Mesh,
    hairline: &Hairline,
    [sectors, rings]: [u32; 2],
) -> Result<Soup, HairgenError> {
    let distance = MeshDistance::new(head);
    let view = FittedView { head: &distance, similarity: &Similarity::IDENTITY };
    hairline.disc(sectors, rings, |direction| view.place(direction))
}
