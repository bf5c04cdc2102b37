//! Hairstyles: from a file with a style to files with its hairs.

use crate::file::{LARGEST_MESH, open};
use crate::folder::claim;
use crate::{SimError, read_text, write_atomically};
use nalgebra::{Isometry3, Point3, Rotation3, Vector3};
use rapunzel_collision::field::{Mesh, Soup};
use rapunzel_export::surface::{self, Placed};
use rapunzel_export::{ExportError, Frame, Strand, data, hair, obj, ply, usd, vtp};
use rapunzel_fiber::so3;
use rapunzel_hairgen::HairgenError;
pub use rapunzel_hairgen::style::{GrowthStage, Hairstyle, Style, StyleReport};
use rapunzel_scene::{Scene, style_from_ron};
use rapunzel_studio::sheet::{self, PreviewFrame};
use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

/// Radius of the hairs in the files, m.
const HAIR_RADIUS: f64 = 35e-6;
/// Hairs of the picture at most: more are not told apart.
const SHOWN: usize = 4000;

/// Names of the files.
pub(crate) const HAIRS: [&str; 6] =
    ["hairs.vtp", "hairs.usda", "hairs.hair", "hairs.data", "hairs.obj", "hairs.ply"];
pub(crate) const HEAD: &str = "head.vtp";
const PREVIEW: &str = "preview.png";

/// Reads the style in a file.
///
/// # Errors
/// [`SimError::Io`], and [`SimError::Scene`] for what is no style.
pub fn read(path: &Path) -> Result<Style, SimError> {
    Ok(style_from_ron(&read_text(path)?)?)
}

/// Grows a style whose files are relative to `folder`; every part of the work is told to `at`.
///
/// # Errors
/// [`SimError::Hairstyle`].
pub fn grow(style: &Style, folder: &Path, at: &dyn Fn(GrowthStage)) -> Result<Hairstyle, SimError> {
    Ok(style.grow(&|path| bytes(&folder.join(path)), at)?)
}

/// Paths of all files that belong to a scene beside its text: those that it names, and those that
/// its styles name.
///
/// # Errors
/// Those of [`read`].
pub(crate) fn files(scene: &Scene) -> Result<Vec<PathBuf>, SimError> {
    let mut paths: Vec<_> = scene.files().map(Path::to_owned).collect();
    for path in scene.styles() {
        let folder = path.parent().unwrap_or(Path::new(""));
        paths.extend(read(path)?.files().map(|file| folder.join(file)));
    }
    Ok(paths)
}

/// The closed surface of the head that the style in a file grows on, meters, z up, its face along
/// the negative y axis.
///
/// # Errors
/// Those of [`read`], and [`SimError::Hairstyle`].
pub(crate) fn head_mesh(path: &Path) -> Result<Mesh, SimError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mesh = read(path)?.head_mesh(&|path| bytes(&folder.join(path)))?;
    let vertices = mesh.vertices().iter().map(|vertex| upright(*vertex)).collect();
    let soup = Soup { vertices, triangles: mesh.triangles().to_vec() };
    Mesh::new(soup).map_err(|source| HairgenError::Surface { what: "the head", source }.into())
}

/// The bytes of a file that a style names.
fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path, LARGEST_MESH).map_err(io::Error::other)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Writes the hairs in all formats, the head, and a picture, two files at a time. Meters and y up,
/// but in USD, which has z up as all that is written.
///
/// # Errors
/// Those of [`claim`], and of files that cannot be written.
pub fn save(style: &Hairstyle, folder: &Path) -> Result<(), SimError> {
    claim(folder, &[&HAIRS[..], &[HEAD, PREVIEW]].concat())?;
    let curves = || style.hairs.iter().filter(|curve| curve.len() > 1);
    let frame = Frame { index: 0, time: 0.0, strands: curves().map(strand).collect() };
    let write = |name: &str, with: &dyn Fn(&mut BufWriter<File>) -> Result<(), ExportError>| {
        write_atomically(&folder.join(name), |to| with(to).map_err(io::Error::other))
    };
    let plain_files = || {
        write(HAIRS[0], &|to| vtp::write(to, &frame))?;
        write(HAIRS[2], &|to| hair::write(to, &frame))?;
        write(HAIRS[3], &|to| data::write(to, &frame))?;
        write(HAIRS[4], &|to| obj::write(to, &frame))?;
        write(HAIRS[5], &|to| ply::write(to, &frame, ply::PlyEncoding::Binary))
    };
    let scene_files = || {
        write(HAIRS[1], &|to| stage(to, curves()))?;
        let head = placed(style, |p| p);
        write(HEAD, &|to| surface::write(to, 0.0, std::slice::from_ref(&head)))?;
        let every = frame.strands.len().div_ceil(SHOWN).max(1);
        let strands = curves()
            .step_by(every)
            .map(|curve| strand(&curve.iter().map(|p| upright(*p)).collect::<Vec<_>>()));
        let shown = Frame { index: 0, time: 0.0, strands: strands.collect() };
        let head = placed(style, upright);
        write(PREVIEW, &|to| {
            let frame = PreviewFrame::new(shown.clone(), Vec::new()).map_err(io::Error::other)?;
            let sheet = sheet::write(to, &[frame], &[vec![head.clone()]], &[]);
            Ok(sheet.map_err(io::Error::other)?)
        })
    };
    let (plain, scene) = rayon::join(plain_files, scene_files);
    plain.and(scene)
}

/// From y up to z up.
pub(crate) fn upright(p: Point3<f64>) -> Point3<f64> {
    Point3::new(p.x, -p.z, p.y)
}

fn placed(style: &Hairstyle, turn: impl Fn(Point3<f64>) -> Point3<f64>) -> Placed {
    let mesh = &style.surfaces.head;
    let vertices = mesh.vertices().iter().map(|p| turn(*p)).collect();
    let triangles = mesh.triangles().to_vec();
    Placed { pose: Isometry3::identity(), surface: Soup { vertices, triangles } }
}

/// The hairs as a USD stage.
fn stage<'a>(
    to: &mut impl Write,
    curves: impl Iterator<Item = &'a [Point3<f64>]>,
) -> Result<(), ExportError> {
    let strands: Vec<_> = curves
        .map(|curve| strand(&curve.iter().map(|p| upright(*p)).collect::<Vec<_>>()))
        .collect();
    let count = strands.len();
    let mut frame = io::Cursor::new(Vec::new());
    vtp::write(&mut frame, &Frame { index: 0, time: 0.0, strands })?;
    let bytes = frame.into_inner();
    let shape = usd::PrimShape::Curves { strands: 0..count, guide: false };
    let prim = usd::Prim { name: "Hairs".to_owned(), shape, color: [0.12, 0.06, 0.03] };
    let timeline = usd::Timeline { frames: 1, rate: 24.0, end: 0.0 };
    let open = |_| Ok(io::Cursor::new(&bytes[..]));
    usd::Strands::new(timeline, "Style", vec![prim], open)?.write(to, None)
}

/// The hairs and the head of a style, z up.
pub(crate) fn shown(style: &Hairstyle) -> (Frame, Placed) {
    let upright = |curve: &[Point3<f64>]| curve.iter().map(|p| upright(*p)).collect::<Vec<_>>();
    let curves = style.hairs.iter().filter(|curve| curve.len() > 1);
    let strands = curves.map(|curve| strand(&upright(curve))).collect();
    (Frame { index: 0, time: 0.0, strands }, placed(style, self::upright))
}

/// A hair at rest, its frames carried along without a twist.
pub(crate) fn strand(points: &[Point3<f64>]) -> Strand {
    let segments = points.len() - 1;
    let mut frame = Rotation3::identity();
    let frames = points.windows(2).map(|ends| {
        let turn = so3::between(&(frame * Vector3::z()), &(ends[1] - ends[0]));
        frame = turn.unwrap_or_default() * frame;
        frame
    });
    let frames = frames.collect();
    Strand {
        points: points.to_vec(),
        radii: vec![HAIR_RADIUS; segments + 1],
        velocities: vec![Vector3::zeros(); segments + 1],
        frames,
        curvatures: vec![Vector3::zeros(); segments + 1],
        forces: vec![Vector3::zeros(); segments],
        contact_forces: vec![Vector3::zeros(); segments + 1],
        charges: vec![0.0; segments + 1],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A scene beside a folder with a style, which names an image beside itself.
    #[test]
    fn files_of_a_style_belong_to_the_scene() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("styles")).expect("a folder");
        let style = "(length: Image(file: \"length.png\", black: 0.0, white: 0.3))";
        std::fs::write(folder.path().join("styles/short.ron"), style).expect("a file");
        let text = "(format: 1, duration: 0.1,
            objects: [(shape: Head(style: \"styles/short.ron\", spacing: 0.003))],
            fibers: [(length: 0.1, segments: 9, section: Circle(radius: 3.5e-5))],
            contact: (friction: Isotropic(0.3)), stepper: (dt: 1e-3))";
        let scene = Scene::from_ron(text).expect("a scene").seen_from(folder.path());
        let expected =
            ["styles/short.ron", "styles/length.png"].map(|file| folder.path().join(file));
        assert_eq!(files(&scene).expect("a style"), expected);
    }
}
