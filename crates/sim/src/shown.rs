//! What can be drawn: the frames of a run, the start of a scene, a style, strands of a file.

use crate::file::{LARGEST_MESH, kind, open};
use crate::folder::{SCENE, frame_name, objects_name};
use crate::scene::Scene;
use crate::style::{self, GrowthStage};
use crate::{BuildStage, SimError, World, read_text};
use nalgebra::{Isometry3, Point3};
use rapunzel_export::surface::{self, Placed};
use rapunzel_export::{Frame, vtp};
use rapunzel_fiber::Section;
use rapunzel_strands::{ReadOptions, StrandFile, StrandFormat};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Frames that can be drawn.
#[derive(Debug)]
pub struct Shown {
    source: ShownSource,
    /// Number of frames.
    count: usize,
    /// Ratio of the second semi-axis of the sections of all fibres to the first; none if they are
    /// round, or differ.
    ratio: Option<f64>,
}

#[derive(Debug)]
enum ShownSource {
    /// The folder of a run.
    Run(PathBuf),
    /// What there is one of.
    Still(Box<ShownFrame>),
}

/// Fibres and objects at one instant; z is up.
#[derive(Debug, Clone)]
pub struct ShownFrame {
    /// The fibres.
    pub frame: Frame,
    /// The objects.
    pub objects: Vec<Placed>,
}

/// A part of the work of [`Shown::open`].
#[derive(Debug, Clone, Copy)]
pub enum ShownStage {
    /// A scene is built.
    Building(BuildStage),
    /// A style grows.
    Growing(GrowthStage),
}

impl Shown {
    /// Opens the folder of a run or of a grown style, a file with a scene or a style, which is
    /// built or grown, a file of frames (`vtp`), or one of strands. Parts of long work are told to
    /// `at`.
    ///
    /// # Errors
    /// [`SimError::Nothing`] if there is nothing to draw; errors of scenes, styles and files. Of a
    /// RON that is neither a scene nor a style the error is that of the scene.
    pub fn open(path: &Path, at: &dyn Fn(ShownStage)) -> Result<Self, SimError> {
        let still = |frame: Frame, objects| Self {
            source: ShownSource::Still(Box::new(ShownFrame { frame, objects })),
            count: 1,
            ratio: None,
        };
        if path.is_dir() {
            return Self::folder(path);
        }
        match kind(path).as_str() {
            "ron" => {
                let text = read_text(path)?;
                let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
                let beside = whole.parent().unwrap_or(Path::new("."));
                match Scene::from_ron(&text) {
                    Ok(scene) => {
                        let scene = scene.seen_from(beside);
                        let told = |stage| at(ShownStage::Building(stage));
                        let world = World::build_observed(&scene, &told)?;
                        let strands = world.stepper().strands().collect();
                        let frame = Frame { index: 0, time: 0.0, strands };
                        let objects = world.surfaces().collect();
                        Ok(Self { ratio: ratio(&scene), ..still(frame, objects) })
                    }
                    Err(error) => {
                        let Ok(style) = style::read(path) else { return Err(error.into()) };
                        let told = |stage| at(ShownStage::Growing(stage));
                        let (frame, head) = style::shown(&style::grow(&style, beside, &told)?);
                        Ok(still(frame, vec![head]))
                    }
                }
            }
            "vtp" => Ok(still(read_frame(path)?, Vec::new())),
            _ => Ok(still(read_strands(path)?, Vec::new())),
        }
    }

    fn folder(path: &Path) -> Result<Self, SimError> {
        let count =
            (0..).take_while(|index| path.join(frame_name(*index, "vtp")).is_file()).count();
        if count > 0 {
            // The scene is there for the sections only: without it they are round.
            let scene = read_text(&path.join(SCENE)).ok();
            let scene = scene.and_then(|text| Scene::from_ron(&text).ok());
            let ratio = scene.as_ref().and_then(ratio);
            return Ok(Self { source: ShownSource::Run(path.to_owned()), count, ratio });
        }
        let hairs = path.join(style::HAIRS[0]);
        if !hairs.is_file() {
            return Err(SimError::Nothing { path: path.to_owned() });
        }
        // Files of a style have y up.
        let upright = |p: &mut Point3<f64>| *p = style::upright(*p);
        let points: Vec<_> = read_frame(&hairs)?.strands.into_iter().map(|s| s.points).collect();
        let strands = points.into_iter().map(|mut points| {
            points.iter_mut().for_each(upright);
            style::strand(&points)
        });
        let frame = Frame { index: 0, time: 0.0, strands: strands.collect() };
        let mut objects = read_objects(&path.join(style::HEAD))?;
        for object in &mut objects {
            object.surface.vertices.iter_mut().for_each(upright);
            object.pose = Isometry3::identity();
        }
        let source = ShownSource::Still(Box::new(ShownFrame { frame, objects }));
        Ok(Self { source, count: 1, ratio: None })
    }

    /// Number of frames, one at least.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Ratio of the second semi-axis of the sections of all fibres to the first; none if they are
    /// round, or differ.
    #[must_use]
    pub fn ratio(&self) -> Option<f64> {
        self.ratio
    }

    /// Reads a frame; of a number behind the last one that.
    ///
    /// # Errors
    /// [`SimError::Export`] and [`SimError::Io`] for files that cannot be read.
    pub fn frame(&self, index: usize) -> Result<ShownFrame, SimError> {
        let folder = match &self.source {
            ShownSource::Still(still) => return Ok(ShownFrame::clone(still)),
            ShownSource::Run(folder) => folder,
        };
        let index = index.min(self.count - 1);
        let frame = read_frame(&folder.join(frame_name(index, "vtp")))?;
        // Where no object moves there is one file for all frames.
        let file = [index, 0].map(|index| folder.join(objects_name(index, "vtp")));
        let file = file.iter().find(|file| file.is_file());
        let objects = file.map_or_else(|| Ok(Vec::new()), |file| read_objects(file))?;
        Ok(ShownFrame { frame, objects })
    }
}

/// The ratio of semi-axes that all fibres of a scene have.
fn ratio(scene: &Scene) -> Option<f64> {
    let of = |section: &Option<Section>| match section {
        Some(Section::Ellipse { a, b }) => Some(b / a),
        Some(Section::Circle { .. }) | None => None,
    };
    let bundle = scene.fibers.first()?;
    let first = of(&bundle.taper.first().and_then(|point| point.section).or(bundle.section))?;
    let same = |bundle: &crate::scene::Bundle| {
        let points = bundle.taper.iter().map(|point| of(&point.section.or(bundle.section)));
        let whole = bundle.taper.is_empty().then(|| of(&bundle.section));
        points.chain(whole).all(|ratio| ratio == Some(first))
    };
    scene.fibers.iter().all(same).then_some(first)
}

fn read_frame(path: &Path) -> Result<Frame, SimError> {
    vtp::read(&mut open(path, LARGEST_MESH)?).map_err(SimError::export(path))
}

fn read_objects(path: &Path) -> Result<Vec<Placed>, SimError> {
    surface::read(&mut open(path, LARGEST_MESH)?).map_err(SimError::export(path))
}

fn read_strands(path: &Path) -> Result<Frame, SimError> {
    let mut bytes = Vec::new();
    let read = open(path, LARGEST_MESH)?.read_to_end(&mut bytes);
    read.map_err(SimError::io("read", path))?;
    let format = StrandFormat::from_extension(&kind(path));
    let file = StrandFile::read(&bytes, format, &ReadOptions::default());
    let file = file.map_err(|source| SimError::StrandFile { path: path.to_owned(), source })?;
    let set = &file.strands;
    let strand = |index: usize| {
        let mut strand = style::strand(set.strand(index));
        if let Some(radii) = set.radii() {
            strand.radii = radii[set.range(index)].to_vec();
        }
        strand
    };
    Ok(Frame { index: 0, time: 0.0, strands: (0..set.len()).map(strand).collect() })
}
