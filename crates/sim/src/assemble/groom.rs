//! Curves of grooms, from the files that a scene names.

use super::stage::BuildStage;
use crate::file::{LARGEST_MESH, kind, open};
use crate::scene::{Bundle, Groom, GroomSource, GroomUpAxis, RootBall};
use crate::{SimError, style};
use nalgebra::{Isometry3, Point3, UnitQuaternion};
use rapunzel_strands::{ReadOptions, StrandFile, StrandFormat, StrandSet};
use std::f64::consts::PI;
use std::io::Read;
use std::path::Path;

/// A fibre is at least so many radii long.
const SLENDER: f64 = 20.0;
/// A fibre is at least so long, in segments of the longest: shorter segments would limit the step.
const SHORTEST: f64 = 0.5;
/// Fewest segments of a fibre.
const FEWEST: usize = 2;
/// Area of a scalp, m^2, at least: a ball of roots in it takes the part of its disc, twice over.
const SCALP: f64 = 0.03;

/// The curves of a bundle's `groom` (world), m, the longest in as many segments as the bundle says
/// and others in fewer, and longer than a slender fibre of the equivalent `radius`, m, must be.
/// What a user should know is added to the `notes`, and `at` is told of what takes long.
///
/// # Errors
/// [`SimError`] of the file, and [`SimError::NoStrands`] where no fibre is left.
pub(super) fn curves(
    groom: &Groom,
    bundle: &Bundle,
    radius: f64,
    index: usize,
    notes: &mut Vec<String>,
    at: &dyn Fn(BuildStage),
) -> Result<Vec<Vec<Point3<f64>>>, SimError> {
    let path = groom.from.file();
    let name = format!("fibers[{index}], {}", path.display());
    let strands = match &groom.from {
        GroomSource::Style { file, hairs } => {
            let mut style = style::read(file)?;
            style.hairs = Some(*hairs);
            let folder = file.parent().unwrap_or(Path::new(""));
            let grown = style::grow(&style, folder, &|stage| {
                at(BuildStage::Growing { bundle: index, stage });
            })?;
            notes.push(format!("{name}:\n{}", grown.report));
            StrandSet::from_curves(grown.hairs.iter())
        }
        GroomSource::Strands { file, scale, up } => {
            let StrandFile { strands, report } = read(file, *scale, *up, index)?;
            notes.push(format!("{name}: {report}"));
            strands
        }
    };
    let within = |root: &Point3<f64>| {
        let in_ball = |ball: RootBall| {
            (style::upright(*root) - Point3::from(ball.center)).norm() <= ball.radius
        };
        groom.roots_within.is_none_or(in_ball)
    };
    let chosen = || (0..strands.len()).filter(|&strand| within(&strands.strand(strand)[0]));
    let longest = chosen().map(|strand| strands.length(strand)).fold(0.0, f64::max);
    let segment = longest / bundle.segments as f64;
    let least = (SLENDER * radius).max(SHORTEST * segment);
    let long = || chosen().filter(|&strand| strands.length(strand) >= least);
    let short = chosen().count() - long().count();
    if short > 0 {
        notes.push(format!(
            "{name}: {short} strands are left out that are shorter than {least:.1e} m: {SLENDER} \
             radii, or half a segment of the longest"
        ));
    }
    let strands = StrandSet::from_curves(long().map(|strand| strands.strand(strand)));
    if strands.is_empty() {
        return Err(SimError::NoStrands { bundle: index, path: path.to_owned() });
    }
    let segments = |strand: usize| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part")]
        let count = (strands.length(strand) / segment).ceil() as usize;
        count.clamp(FEWEST, bundle.segments)
    };
    let failed = |source| SimError::Strands { bundle: index, path: path.to_owned(), source };
    let resampled = strands.resampled_by(segments).map_err(failed)?;
    notes.push(format!(
        "{name}: {} strands in segments of about {:.1e} m, which are off the curves by at most \
         {:.1e} m",
        strands.len(),
        segment,
        resampled.error
    ));
    let pose = pose(groom, bundle);
    let place =
        |points: &[Point3<f64>]| points.iter().map(|point| pose * style::upright(*point)).collect();
    Ok(resampled.strands.iter().map(place).collect())
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
    up: Option<GroomUpAxis>,
    bundle: usize,
) -> Result<StrandFile, SimError> {
    let mut bytes = Vec::new();
    let read = open(path, LARGEST_MESH)?.read_to_end(&mut bytes);
    read.map_err(SimError::io("read", path))?;
    let up = up.map(|up| match up {
        GroomUpAxis::Y => rapunzel_strands::UpAxis::Y,
        GroomUpAxis::Z => rapunzel_strands::UpAxis::Z,
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
