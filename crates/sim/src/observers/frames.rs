use super::Observer;
use crate::export::{self, ExportError, Frame, Strand};
use crate::folder::{FRAMES, OBJECTS_USD, PREVIEW, PVD, RunFolder, USD};
use crate::manifest::Entry;
use crate::scene::{Format, Motion, Moves, Object, Wind};
use crate::storage::save;
use crate::{Plan, SimError, World};
use rapunzel_collision::field::Soup;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// Frames on the contact sheet.
const PREVIEW_FRAMES: usize = 12;

/// Which files hold the objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shown {
    /// There are none.
    None,
    /// One for all frames: none moves.
    Once,
    /// One for each frame.
    Always,
}

impl Shown {
    pub(crate) fn of(objects: &[Object]) -> Self {
        let still = |one: &Object| one.moves == Moves::Led && one.motion == Motion::Fixed;
        match objects {
            [] => Self::None,
            _ if objects.iter().all(still) => Self::Once,
            _ => Self::Always,
        }
    }

    /// The number of the file for a frame.
    fn file(self, frame: usize) -> Option<usize> {
        match self {
            Self::None => None,
            Self::Once => Some(0),
            Self::Always => Some(frame),
        }
    }
}

/// Writes a file for every frame, and at the end those that hold many.
///
/// A frame's VTP holds it at full precision; what needs all frames reads them back from there, so
/// that neither memory nor a restart matters.
#[derive(Debug)]
pub(crate) struct FrameWriter {
    folder: PathBuf,
    formats: Vec<Format>,
    objects: Shown,
    /// Which previews show.
    wind: Wind,
    plan: Plan,
    /// Frames written.
    count: usize,
}

impl FrameWriter {
    /// The files of a run with so many frames.
    pub(crate) fn files(formats: &[Format], objects: Shown, frames: u64) -> Vec<Entry> {
        let of_frames = |extension| Entry::series(&format!("{FRAMES}/frame"), extension, frames);
        let mut files = vec![of_frames("vtp"), PVD.into(), PREVIEW.into()];
        for format in formats {
            match format {
                Format::Hair => files.push(of_frames("hair")),
                Format::Pov => files.push(of_frames("pov")),
                Format::Usd => files.extend([USD.into(), OBJECTS_USD.into()]),
            }
        }
        let of_objects = match objects {
            Shown::None => 0,
            Shown::Once => 1,
            Shown::Always => frames,
        };
        if of_objects > 0 {
            files.push(Entry::series(&format!("{FRAMES}/objects"), "vtp", of_objects));
        }
        files
    }

    /// The folder of the frames must be there.
    pub(crate) fn new(
        folder: &RunFolder,
        formats: &[Format],
        objects: Shown,
        wind: Wind,
        plan: Plan,
    ) -> Self {
        let (folder, formats) = (folder.files().to_owned(), formats.to_vec());
        Self { folder, formats, objects, wind, plan, count: 0 }
    }

    fn file(&self, index: usize, extension: &str) -> PathBuf {
        self.folder.join(name(index, extension))
    }

    /// Lists the frames so far for ParaView.
    fn write_pvd(&self) -> Result<(), SimError> {
        let mut files = Vec::new();
        for index in 0..self.count {
            let time = self.plan.frame_time(index as u64);
            files.push((time, 0, name(index, "vtp")));
            files.extend(self.objects.file(index).map(|file| (time, 1, objects_name(file))));
        }
        let entries = files.iter().map(|(time, part, name)| (*time, *part, name.as_str()));
        save(&self.folder.join(PVD), |to| export::pvd::write(to, entries))
    }

    fn read(&self, index: usize) -> Result<Frame, ExportError> {
        export::vtp::read(&mut BufReader::new(File::open(self.file(index, "vtp"))?))
    }

    fn read_objects(&self, file: usize) -> Result<Soup, ExportError> {
        let path = self.folder.join(objects_name(file));
        export::surface::read_vtp(&mut BufReader::new(File::open(path)?))
    }

    fn write_objects_usd(&self) -> Result<(), SimError> {
        let files = match self.objects {
            Shown::None => return Ok(()),
            Shown::Once => 1,
            Shown::Always => self.count,
        };
        let times: Vec<f64> = (0..files).map(|i| self.plan.frame_time(i as u64)).collect();
        let frames = (0..files).map(|file| self.read_objects(file));
        save(&self.folder.join(OBJECTS_USD), |to| export::surface::write_usda(to, &times, frames))
    }

    fn write_usd(&self) -> Result<(), SimError> {
        let times: Vec<f64> = (0..self.count).map(|i| self.plan.frame_time(i as u64)).collect();
        let frames = (0..self.count).map(|i| self.read(i));
        // Straight lines between the nodes are what was simulated.
        save(&self.folder.join(USD), |to| {
            export::usda::write(to, export::usda::Curve::Linear, &times, frames)
        })
    }

    fn write_preview(&self) -> Result<(), SimError> {
        let shown = self.count.min(PREVIEW_FRAMES);
        let indices = || (0..shown).map(|i| i * (self.count - 1) / (shown - 1).max(1));
        let surfaces = indices().filter_map(|index| self.objects.file(index));
        save(&self.folder.join(PREVIEW), |to| {
            let picture = |index| export::preview::Picture::new(self.read(index)?);
            let frames = indices().map(picture).collect::<Result<Vec<_>, _>>()?;
            let surfaces =
                surfaces.map(|file| self.read_objects(file)).collect::<Result<Vec<_>, _>>()?;
            let winds: Vec<_> = frames.iter().map(|frame| self.wind.at(frame.time)).collect();
            export::preview::write(to, &frames, &surfaces, &winds)
        })
    }
}

impl Observer for FrameWriter {
    fn observe(&mut self, world: &World) -> Result<(), SimError> {
        if !self.plan.is_frame(world.steps()) {
            return Ok(());
        }
        let index = self.count;
        let whole = self.formats.iter().any(|format| *format != Format::Usd);
        let (time, strands) = (world.time(), || strands(world));
        let frame = whole.then(|| Frame { index, time, strands: strands().collect() });
        for format in &self.formats {
            match (format, &frame) {
                (Format::Hair, Some(frame)) => {
                    save(&self.file(index, "hair"), |to| export::hair::write(to, frame))?;
                }
                (Format::Pov, Some(frame)) => {
                    save(&self.file(index, "pov"), |to| export::pov::write(to, frame))?;
                }
                _ => (),
            }
        }
        drop(frame);
        if self.objects.file(index) == Some(index) {
            let surfaces: Vec<_> = world.surfaces().collect();
            save(&self.folder.join(objects_name(index)), |to| {
                export::surface::write_vtp(to, world.time(), &surfaces)
            })?;
        }
        let counts = counts(world);
        save(&self.file(index, "vtp"), |to| {
            export::vtp::write_strands(to, (index, time), &counts, strands())
        })?;
        self.count += 1;
        Ok(())
    }

    fn mark(&mut self) -> Result<u64, SimError> {
        Ok(self.count as u64)
    }

    fn list(&mut self) -> Result<(), SimError> {
        self.write_pvd()
    }

    fn relocate(&mut self, folder: &Path) {
        self.folder = folder.to_owned();
    }

    fn rewind(&mut self, mark: u64) -> Result<(), SimError> {
        self.count = usize::try_from(mark).unwrap_or(usize::MAX);
        // A loss of power can cost files that were written just before.
        let is_there = |path: &PathBuf| fs::metadata(path).is_ok_and(|data| data.len() > 0);
        match (0..self.count).map(|i| self.file(i, "vtp")).find(|path| !is_there(path)) {
            Some(path) => {
                let why = format!("does not fit the folder: {} is lost", path.display());
                Err(SimError::Checkpoint { path, why })
            }
            None => Ok(()),
        }
    }

    fn finish(&mut self) -> Result<(), SimError> {
        self.write_pvd()?;
        if self.formats.contains(&Format::Usd) {
            self.write_usd()?;
            self.write_objects_usd()?;
        }
        self.write_preview()
    }
}

/// The name of a frame's file as seen from the folder of the run.
fn name(index: usize, extension: &str) -> String {
    format!("{FRAMES}/frame-{index:06}.{extension}")
}

/// The name of a file of objects as seen from the folder of the run.
fn objects_name(index: usize) -> String {
    format!("{FRAMES}/objects-{index:06}.vtp")
}

/// All fibres as they are now, one after another: all of them together are half as much as the world.
fn strands(world: &World) -> impl Iterator<Item = Strand> {
    let strand = |i: usize| {
        let state = world.state(i);
        let nodes = world.assembly().layout().node_range(i);
        Strand {
            points: state.positions,
            radii: world.assembly().radii()[nodes].to_vec(),
            velocities: state.velocities,
            frames: state.frames,
            curvatures: state.curvatures,
            forces: state.forces,
        }
    };
    let springs = world.springs.iter().flat_map(|springs| springs.strands());
    springs.chain((0..world.assembly().fibers().len()).map(strand))
}

/// The number of points of each.
fn counts(world: &World) -> Vec<usize> {
    let layout = world.assembly().layout();
    let springs = world.springs.iter().flat_map(|springs| springs.strands());
    let springs = springs.map(|strand| strand.points.len());
    springs.chain((0..layout.fibers()).map(|i| layout.node_range(i).len())).collect()
}
