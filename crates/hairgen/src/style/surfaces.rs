use super::spec::{HairSource, HeadSource, Style};
use crate::fit::{FitReport, HeadTemplate, fit};
use crate::head::ParametricHead;
use crate::surface::bounds;
use crate::{FieldResolution, HairgenError, SurfaceField};
use nalgebra::Point3;
use rapunzel_collision::CollisionError;
use rapunzel_collision::field::{
    DistanceField, Mesh, MeshDistance, Repairs, Sample, Soup, SurfaceTree,
};
use std::path::Path;
use std::{fmt, io};

/// Reads a file of the style, by its path relative to the style's folder.
pub(super) type ReadFile<'a> = &'a (dyn Fn(&Path) -> io::Result<Vec<u8>> + Sync);

/// Sectors and rings of the scalp of a head without a scan.
const SCALP: [u32; 2] = [120, 40];

/// Smallest and largest extent of a surface from a file, m: from a doll's to a bust with long hair.
const SIZES: [f64; 2] = [0.02, 2.5];

/// A surface of a file that cuts through itself, where inside and outside are not sure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossedSurface {
    /// Which surface.
    pub what: &'static str,
    /// Number of its triangles that others cut.
    pub faces: usize,
    /// Where the first of them is cut, in the unit and frame of the file.
    pub place: Point3<f64>,
}

impl fmt::Display for CrossedSurface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = <[f64; 3]>::from(self.place);
        write!(
            f,
            "{} cuts through itself at {} faces, such as near ({x:.4}, {y:.4}, {z:.4}); hair may \
             be wrong there: unite its parts, or mesh it again",
            self.what, self.faces
        )
    }
}

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
    /// Those of the files that cut through themselves.
    pub crossed: Vec<CrossedSurface>,
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
        let mut files = SurfaceFiles { read, mended: Vec::new(), crossed: Vec::new() };
        let Ground { head, scalp, parametric, scan, fit } = Ground::of(style, &mut files)?;
        let resolution = FieldResolution::default();
        let of_solid = |what, mesh: &Mesh| SurfaceField::solid(what, mesh, resolution);
        let head_field = of_solid("the head", &head)?;
        let scalp = match &style.scalp {
            Some(file) => files.scalp(file, &head_field)?,
            None => scalp,
        };
        let (hull, hull_field) = match &style.hair {
            HairSource::Volume(volume) => {
                let head = parametric.ok_or(HairgenError::VolumeWithoutHead)?;
                let mesh = Mesh::new(head.hull(volume)?).map_err(invalid("the hair"))?;
                (open(&mesh), HullField::Solid(of_solid("the hair", &mesh)?))
            }
            HairSource::Solid(file) => {
                let mesh = files.solid("the hair", file)?;
                check_size("the hair", mesh.bounds())?;
                (open(&mesh), HullField::Solid(of_solid("the hair", &mesh)?))
            }
            HairSource::Scan => {
                let mesh = scan.ok_or(HairgenError::HairWithoutScan)?;
                (open(&mesh), HullField::Solid(of_solid("the scan", &mesh)?))
            }
            HairSource::Shell { file, thickness } => {
                let shell = files.soup(file)?;
                check_size("the hair", bounds(&shell))?;
                let field = SurfaceField::shell("the hair", &shell, *thickness, resolution)?;
                (shell, HullField::Shell(field))
            }
        };
        let SurfaceFiles { mended, crossed, .. } = files;
        Ok(Self { head, scalp, hull, head_field, hull_field, fit, mended, crossed })
    }
}

impl Style {
    /// The closed surface of the bald head, meters. Files are asked of `read`, by their paths in
    /// the style. Cost: that of the fit, if it is fitted to a scan.
    ///
    /// # Errors
    /// [`HairgenError`] of a head that cannot be made.
    pub fn head_mesh(&self, read: ReadFile<'_>) -> Result<Mesh, HairgenError> {
        let mut files = SurfaceFiles { read, mended: Vec::new(), crossed: Vec::new() };
        Ok(Ground::of(self, &mut files)?.head)
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
}

impl Ground {
    fn of(style: &Style, files: &mut SurfaceFiles<'_>) -> Result<Self, HairgenError> {
        let plain = |head, scalp| Self { head, scalp, parametric: None, scan: None, fit: None };
        Ok(match &style.head {
            HeadSource::Parametric { measures, hairline } => {
                let head = ParametricHead::new(*measures, hairline.clone())?;
                let mesh = Mesh::new(head.mesh()).map_err(invalid("the head"))?;
                let scalp = head.scalp(SCALP[0], SCALP[1])?;
                Self { parametric: Some(head), ..plain(mesh, scalp) }
            }
            HeadSource::Mesh { file, hairline } => {
                let mesh = files.head("the head", file)?;
                let scalp = crate::fit::scalp_of(&mesh, hairline, SCALP)?;
                plain(mesh, scalp)
            }
            HeadSource::Scan { file, template, hairline, options } => {
                let template = match template {
                    Some(file) => {
                        let mesh = files.head("the template of the head", file)?;
                        HeadTemplate { mesh: open(&mesh), hairline: hairline.clone() }
                    }
                    None => {
                        let measures = crate::head::HeadMeasures::default();
                        HeadTemplate::from(&ParametricHead::new(measures, hairline.clone())?)
                    }
                };
                let fitted = fit(&files.solid("the scan", file)?, &template, options)?;
                let head = Mesh::new(fitted.head).map_err(invalid("the fitted head"))?;
                let (scan, fit) = (Some(fitted.hull), Some(fitted.report));
                Self { scan, fit, ..plain(head, fitted.scalp) }
            }
        })
    }
}

/// The error of a surface.
fn invalid(what: &'static str) -> impl FnOnce(CollisionError) -> HairgenError {
    move |source| HairgenError::Surface { what, source }
}

/// Meshes from files, and what was found of them.
struct SurfaceFiles<'a> {
    read: ReadFile<'a>,
    mended: Vec<(&'static str, Repairs)>,
    crossed: Vec<CrossedSurface>,
}

impl SurfaceFiles<'_> {
    /// The triangles of a file, by the ending of its name.
    fn soup(&self, file: &Path) -> Result<Soup, HairgenError> {
        let failed = |problem: String| HairgenError::File { file: file.to_owned(), problem };
        let bytes = (self.read)(file).map_err(|error| failed(error.to_string()))?;
        let ending = file.extension().and_then(|e| e.to_str()).unwrap_or_default();
        let soup = match ending.to_ascii_lowercase().as_str() {
            "ply" => Soup::read_ply(&bytes[..]),
            "obj" => Soup::read_obj(&bytes[..]),
            "stl" => Soup::read_stl(&bytes[..]),
            _ => return Err(failed("must be .ply, .obj or .stl".to_owned())),
        };
        soup.map_err(|error| failed(error.to_string()))
    }

    /// A closed surface.
    fn solid(&mut self, what: &'static str, file: &Path) -> Result<Mesh, HairgenError> {
        let (mesh, repairs) = Mesh::repaired(self.soup(file)?).map_err(invalid(what))?;
        self.note(what, repairs, &open(&mesh))?;
        Ok(mesh)
    }

    /// A head in meters about the origin.
    fn head(&mut self, what: &'static str, file: &Path) -> Result<Mesh, HairgenError> {
        let mesh = self.solid(what, file)?;
        check_size(what, mesh.bounds())?;
        // Also of one that cuts through itself, whose nearest face may tell the wrong side.
        if MeshDistance::new(&mesh).tree().winding_number(&Point3::origin()) < 0.5 {
            return Err(HairgenError::HeadOrigin { what });
        }
        Ok(mesh)
    }

    /// An open surface on the head.
    fn scalp(&mut self, file: &Path, head: &SurfaceField) -> Result<Soup, HairgenError> {
        let outward = |p: &Point3<f64>| head.sample(p).gradient;
        let (scalp, repairs) = self.soup(file)?.repaired(outward).map_err(HairgenError::scalp)?;
        check_size("the scalp", bounds(&scalp))?;
        self.note("the scalp", repairs, &scalp)?;
        Ok(scalp)
    }

    /// Notes what was done to a surface, and where it cuts through itself.
    fn note(
        &mut self,
        what: &'static str,
        repairs: Repairs,
        soup: &Soup,
    ) -> Result<(), HairgenError> {
        if repairs != Repairs::default() {
            self.mended.push((what, repairs));
        }
        let crossings = SurfaceTree::new(soup).map_err(invalid(what))?.crossings();
        if let Some(first) = crossings.first() {
            self.crossed.push(CrossedSurface { what, faces: crossings.len(), place: first.place });
        }
        Ok(())
    }
}

/// Checks that a surface has the size of a head with or without hair and shoulders, in meters.
fn check_size(what: &'static str, [low, high]: [Point3<f64>; 2]) -> Result<(), HairgenError> {
    let (size, [least, most]) = ((high - low).max(), SIZES);
    // Of what is not finite a vertex is told where its field is made.
    if size.is_finite() && !(least..=most).contains(&size) {
        return Err(HairgenError::Size { what, size, least, most });
    }
    Ok(())
}

/// The triangles of a mesh.
fn open(mesh: &Mesh) -> Soup {
    Soup { vertices: mesh.vertices().to_vec(), triangles: mesh.triangles().to_vec() }
}
