use super::spec::{HairSource, HeadSource, Style};
use crate::fit::{FitReport, HeadTemplate, fit};
use crate::head::ParametricHead;
use crate::{FieldResolution, HairgenError, SurfaceField};
use nalgebra::Point3;
use rapunzel_collision::CollisionError;
use rapunzel_collision::field::{DistanceField, Mesh, Repairs, Sample, Soup};
use std::io;
use std::path::Path;

/// Reads a file of the style, by its path relative to the style's folder.
pub(super) type ReadFile<'a> = &'a (dyn Fn(&Path) -> io::Result<Vec<u8>> + Sync);

/// Sectors and rings of the scalp of a head without a scan.
const SCALP: [u32; 2] = [120, 40];

/// The surfaces that hair grows between, meters.
#[derive(Debug, Clone)]
pub struct StyleSurfaces {
    /// The closed surface of the bald head.
    pub head: Mesh,
    /// The part of it where hair grows.
    pub scalp: Soup,
    /// The surface of the hair: closed about head and hair, or open.
    pub hull: Soup,
    /// Distance of the head.
    pub head_field: SurfaceField,
    /// Distance of the surface of the hair; negative where hair may be.
    pub hull_field: HullField,
    /// What the fit to a scan found.
    pub fit: Option<FitReport>,
    /// What was mended of the files.
    pub mended: Vec<(&'static str, Repairs)>,
}

/// The distance of the surface of the hair, negative where hair may be.
#[derive(Debug, Clone)]
pub enum HullField {
    /// Of a solid.
    Solid(SurfaceField),
    /// Of a shell that hair does not cross: hair may be on both of its sides.
    Shell(SurfaceField),
}

impl DistanceField for HullField {
    fn sample(&self, point: &Point3<f64>) -> Sample {
        match self {
            Self::Solid(field) => field.sample(point),
            // Forbidden within the shell, allowed on both of its sides.
            Self::Shell(field) => {
                let Sample { value, gradient } = field.sample(point);
                Sample { value: -value, gradient: -gradient }
            }
        }
    }

    fn lipschitz(&self) -> f64 {
        let (Self::Solid(field) | Self::Shell(field)) = self;
        field.lipschitz()
    }

    fn error(&self) -> f64 {
        let (Self::Solid(field) | Self::Shell(field)) = self;
        field.error()
    }

    fn band(&self) -> f64 {
        let (Self::Solid(field) | Self::Shell(field)) = self;
        field.band()
    }
}

impl StyleSurfaces {
    pub(super) fn of(style: &Style, read: ReadFile<'_>) -> Result<Self, HairgenError> {
        let Ground { head, scalp, parametric, scan, fit, mut mended } = Ground::of(style, read)?;
        let scalp = match &style.scalp {
            Some(file) => soup(file, read)?,
            None => scalp,
        };
        let resolution = FieldResolution::default();
        let of_solid = |what, mesh: &Mesh| SurfaceField::solid(what, mesh, resolution);
        let (hull, hull_field) = match &style.hair {
            HairSource::Volume(volume) => {
                let head = parametric.ok_or(HairgenError::VolumeWithoutHead)?;
                let mesh = Mesh::new(head.hull(volume)?).map_err(invalid("the hair"))?;
                (open(&mesh), HullField::Solid(of_solid("the hair", &mesh)?))
            }
            HairSource::Solid(file) => {
                let mesh = solid("the hair", file, read, &mut mended)?;
                (open(&mesh), HullField::Solid(of_solid("the hair", &mesh)?))
            }
            HairSource::Scan => {
                let mesh = scan.ok_or(HairgenError::HairWithoutScan)?;
                (open(&mesh), HullField::Solid(of_solid("the scan", &mesh)?))
            }
            HairSource::Shell { file, thickness } => {
                let shell = soup(file, read)?;
                let field = SurfaceField::shell("the hair", &shell, *thickness, resolution)?;
                (shell, HullField::Shell(field))
            }
        };
        let head_field = of_solid("the head", &head)?;
        Ok(Self { head, scalp, hull, head_field, hull_field, fit, mended })
    }
}

impl Style {
    /// The closed surface of the bald head, meters. Files are asked of `read`, by their paths in
    /// the style. Cost: that of the fit, if it is fitted to a scan.
    ///
    /// # Errors
    /// [`HairgenError`] of a head that cannot be made.
    pub fn head_mesh(&self, read: ReadFile<'_>) -> Result<Mesh, HairgenError> {
        Ok(Ground::of(self, read)?.head)
    }
}

/// What a style grows on.
struct Ground {
    head: Mesh,
    scalp: Soup,
    /// The head with its measures, if it has some.
    parametric: Option<ParametricHead>,
    /// The surface of the scan that the head was fitted to.
    scan: Option<Mesh>,
    fit: Option<FitReport>,
    mended: Vec<(&'static str, Repairs)>,
}

impl Ground {
    fn of(style: &Style, read: ReadFile<'_>) -> Result<Self, HairgenError> {
        let mut mended = Vec::new();
        let plain = |head, scalp| Self {
            head,
            scalp,
            parametric: None,
            scan: None,
            fit: None,
            mended: Vec::new(),
        };
        let ground = match &style.head {
            HeadSource::Parametric { measures, hairline } => {
                let head = ParametricHead::new(*measures, hairline.clone())?;
                let mesh = Mesh::new(head.mesh()).map_err(invalid("the head"))?;
                let scalp = head.scalp(SCALP[0], SCALP[1])?;
                Self { parametric: Some(head), ..plain(mesh, scalp) }
            }
            HeadSource::Mesh { file, hairline } => {
                let mesh = solid("the head", file, read, &mut mended)?;
                let scalp = crate::fit::scalp_of(&mesh, hairline, SCALP)?;
                plain(mesh, scalp)
            }
            HeadSource::Scan { file, template, hairline, options } => {
                let template = match template {
                    Some(file) => {
                        let mesh = solid("the template of the head", file, read, &mut mended)?;
                        HeadTemplate { mesh: open(&mesh), hairline: hairline.clone() }
                    }
                    None => {
                        let measures = crate::head::HeadMeasures::default();
                        HeadTemplate::from(&ParametricHead::new(measures, hairline.clone())?)
                    }
                };
                let scan = solid("the scan", file, read, &mut mended)?;
                let fitted = fit(&scan, &template, options)?;
                let head = Mesh::new(fitted.head).map_err(invalid("the fitted head"))?;
                let (scan, fit) = (Some(fitted.hull), Some(fitted.report));
                Self { scan, fit, ..plain(head, fitted.scalp) }
            }
        };
        Ok(Self { mended, ..ground })
    }
}

/// The error of a surface.
fn invalid(what: &'static str) -> impl FnOnce(CollisionError) -> HairgenError {
    move |source| HairgenError::Surface { what, source }
}

/// The closed mesh in a file; repairs are added to those that are told.
fn solid(
    what: &'static str,
    file: &Path,
    read: ReadFile<'_>,
    mended: &mut Vec<(&'static str, Repairs)>,
) -> Result<Mesh, HairgenError> {
    let (mesh, repairs) = Mesh::repaired(soup(file, read)?).map_err(invalid(what))?;
    if repairs != Repairs::default() {
        mended.push((what, repairs));
    }
    Ok(mesh)
}

/// The triangles of a mesh.
fn open(mesh: &Mesh) -> Soup {
    Soup { vertices: mesh.vertices().to_vec(), triangles: mesh.triangles().to_vec() }
}

/// The triangles of a file, by the ending of its name.
fn soup(file: &Path, read: ReadFile<'_>) -> Result<Soup, HairgenError> {
    let failed = |problem: String| HairgenError::File { file: file.to_owned(), problem };
    let bytes = read(file).map_err(|error| failed(error.to_string()))?;
    let ending = file.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let soup = match ending.to_ascii_lowercase().as_str() {
        "ply" => Soup::read_ply(&bytes[..]),
        "obj" => Soup::read_obj(&bytes[..]),
        "stl" => Soup::read_stl(&bytes[..]),
        _ => return Err(failed("must be .ply, .obj or .stl".to_owned())),
    };
    soup.map_err(|error| failed(error.to_string()))
}
