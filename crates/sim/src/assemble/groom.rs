//! Curves of grooms, from the files that a scene names.

use crate::file::{LARGEST_MESH, kind, open};
use crate::scene::{Bundle, Groom, GroomSource, RootBall, UpAxis};
use crate::{SimError, style};
use nalgebra::{Isometry3, Point3, UnitQuaternion};
use rapunzel_strands::{ReadOptions, StrandFile, StrandFormat, StrandSet};
use std::f64::consts::PI;
use std::io::Read;
use std::path::Path;

/// A fibre is at least so many radii long.
const SLENDER: f64 = 20.0;
/// Area of a scalp, m^2, at least: a ball of roots in it takes the part of its disc, twice over.
const SCALP: f64 = 0.03;

/// The curves of a bundle's `groom` (world), m, each in as many segments as the bundle says, and
/// longer than a slender fibre of the equivalent `radius`, m, must be.
///
/// # Errors
/// [`SimError`] of the file, and [`SimError::NoStrands`] where no fibre is left.
pub(super) fn curves(
    groom: &Groom,
    bundle: &Bundle,
    radius: f64,
    index: usize,
    notes: &mut Vec<String>,
) -> Result<Vec<Vec<Point3<f64>>>, SimError> {
    let path = groom.from.file();
    let name = format!("fibers[{index}], {}", path.display());
    let strands = match &groom.from {
        GroomSource::Style { file, hairs } => {
            let mut style = style::read(file)?;
            style.hairs = Some(*hairs);
            let folder = file.parent().unwrap_or(Path::new(""));
            let grown = style::grow(&style, folder, &|_| ())?;
            notes.push(format!("{name}:\n{}", grown.report));
            StrandSet::from_curves(grown.hairs.iter())
        }
        GroomSource::Strands { file, scale, up } => {
            let StrandFile { strands, report } = read(file, *scale, *up, index)?;
            notes.push(format!("{name}: {report}"));
            strands
        }
    };
    let failed = |source| SimError::Strands { bundle: index, path: path.to_owned(), source };
    let resampled = strands.resampled(bundle.segments).map_err(failed)?;
    notes.push(format!(
        "{name}: {} segments a strand are off the curves by at most {:.1e} m",
        bundle.segments, resampled.error
    ));
    let pose = pose(groom, bundle);
    let least = SLENDER * radius;
    let mut short = 0;
    let mut curves = Vec::with_capacity(resampled.strands.len());
    for (strand, points) in resampled.strands.iter().enumerate() {
        let upright: Vec<_> = points.iter().map(|point| style::upright(*point)).collect();
        let within =
            |ball: RootBall| (upright[0] - Point3::from(ball.center)).norm() <= ball.radius;
        if !groom.roots_within.is_none_or(within) {
            continue;
        }
        if resampled.strands.length(strand) < least {
            short += 1;
            continue;
        }
        curves.push(upright.iter().map(|point| pose * point).collect());
    }
    if short > 0 {
        notes.push(format!(
            "{name}: {short} strands are left out that are shorter than {least:.1e} m, {SLENDER} \
             radii"
        ));
    }
    if curves.is_empty() {
        return Err(SimError::NoStrands { bundle: index, path: path.to_owned() });
    }
    Ok(curves)
}

/// Number of fibres of a groom: of a style at most.
///
/// # Errors
/// [`SimError`] of the file.
pub(crate) fn strand_count(groom: &Groom, index: usize) -> Result<usize, SimError> {
    match &groom.from {
        GroomSource::Style { hairs, .. } => {
            let part = |ball: RootBall| (2.0 * PI * ball.radius.powi(2) / SCALP).min(1.0);
            let part = groom.roots_within.map_or(1.0, part);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part")]
            let count = (*hairs as f64 * part).ceil() as usize;
            Ok(count)
        }
        GroomSource::Strands { file, scale, up } => {
            Ok(read(file, *scale, *up, index)?.strands.len())
        }
    }
}

/// Strands in a file.
fn read(
    path: &Path,
    scale: Option<f64>,
    up: Option<UpAxis>,
    bundle: usize,
) -> Result<StrandFile, SimError> {
    let mut bytes = Vec::new();
    let read = open(path, LARGEST_MESH)?.read_to_end(&mut bytes);
    read.map_err(SimError::io("read", path))?;
    let up = up.map(|up| match up {
        UpAxis::Y => rapunzel_strands::UpAxis::Y,
        UpAxis::Z => rapunzel_strands::UpAxis::Z,
    });
    let options = ReadOptions { meters_per_unit: scale, up, ..ReadOptions::default() };
    let format = StrandFormat::from_extension(&kind(path));
    StrandFile::read(&bytes, format, &options).map_err(|source| SimError::Strands {
        bundle,
        path: path.to_owned(),
        source,
    })
}

/// The pose of a groom in the world.
fn pose(groom: &Groom, bundle: &Bundle) -> Isometry3<f64> {
    let [x, y, z] = groom.turn.map(f64::to_radians);
    let position = Point3::from(bundle.root.position);
    Isometry3::from_parts(position.into(), UnitQuaternion::from_euler_angles(x, y, z))
}
