use super::{Objects, Observer, Show};
use crate::folder::{
    FRAMES, OBJECTS_USD, PREVIEW, PVD, RunFolder, SPRINGS_USD, STAGE, USD, frame_name, objects_name,
};
use crate::manifest::Entry;
use crate::scene::Format;
use crate::storage::save;
use crate::{Plan, SimError, World};
use nalgebra::Isometry3;
use rapunzel_export::surface::Placed;
use rapunzel_export::{self as export, ExportError, Frame, mitsuba, usd};
use rapunzel_scattering::{EUMELANIN, Pigments};
use rapunzel_studio::StudioError;
use rapunzel_studio::sheet::{self, PreviewFrame};
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::BufReader;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Frames on the contact sheet.
const PREVIEW_FRAMES: usize = 12;
/// Most bytes of a USD layer before its samples go into clips.
const LARGEST: usize = 200_000_000;
/// Bytes that are read at once.
const BUFFER: usize = 1 << 16;
/// What the clips of the USD layer hold.
const MANIFEST: &str = "frames/frame-manifest.usda";

/// Writes a file for every frame, and at the end those that hold many.
///
/// A frame's VTP holds it at full precision; what needs all frames reads them back from there, so
/// that neither memory nor a restart matters. All other files are made of those, each by itself:
/// one that cannot be written costs no other.
#[derive(Debug)]
pub(crate) struct FrameWriter {
    folder: PathBuf,
    show: Show,
    plan: Plan,
    /// Frames written.
    count: usize,
}

impl FrameWriter {
    /// The files of a run with so many frames.
    pub(crate) fn files(formats: &[Format], objects: Objects, frames: u64) -> Vec<Entry> {
        let of_frames = |extension| Entry::series(&format!("{FRAMES}/frame"), extension, frames);
        let mut files = vec![of_frames("vtp"), PVD.into(), PREVIEW.into()];
        for format in formats {
            match format {
                Format::Hair => files.push(of_frames("hair")),
                Format::Pov => files.push(of_frames("pov")),
                Format::Mitsuba => files.extend(["txt", "xml"].map(of_frames)),
                Format::Usd => {
                    let layers = [STAGE, USD, SPRINGS_USD, OBJECTS_USD, MANIFEST];
                    files.extend(layers.map(Entry::from));
                    files.push(of_frames("usda"));
                }
            }
        }
        let of_objects = objects.count(frames);
        if of_objects > 0 {
            let of_objects =
                |extension| Entry::series(&format!("{FRAMES}/objects"), extension, of_objects);
            files.push(of_objects("vtp"));
            if formats.contains(&Format::Mitsuba) {
                files.push(of_objects("obj"));
            }
        }
        files
    }

    /// The folder of the frames must be there.
    pub(crate) fn new(folder: &RunFolder, show: Show, plan: Plan) -> Self {
        Self { folder: folder.files().to_owned(), show, plan, count: 0 }
    }

    fn file(&self, index: usize, extension: &str) -> PathBuf {
        self.folder.join(frame_name(index, extension))
    }

    /// Lists the frames so far for ParaView.
    fn write_pvd(&self) -> Result<(), SimError> {
        let mut files = Vec::new();
        for index in 0..self.count {
            let time = self.plan.frame_time(index as u64);
            let objects = self.show.objects.file(index);
            files.push((time, 0, frame_name(index, "vtp")));
            files.extend(objects.map(|file| (time, 1, objects_name(file, "vtp"))));
        }
        let entries = files.iter().map(|(time, part, name)| (*time, *part, name.as_str()));
        save(&self.folder.join(PVD), |to| export::pvd::write(to, entries))
    }

    fn open_frame(&self, index: usize) -> Result<BufReader<File>, ExportError> {
        Ok(BufReader::with_capacity(BUFFER, File::open(self.file(index, "vtp"))?))
    }

    fn open_objects(&self, file: usize) -> Result<BufReader<File>, ExportError> {
        Ok(BufReader::new(File::open(self.folder.join(objects_name(file, "vtp")))?))
    }

    fn read_objects(&self, frame: usize) -> Result<Vec<Placed>, ExportError> {
        let file = self.show.objects.file(frame);
        let read = |file| export::surface::read(&mut self.open_objects(file)?);
        file.map_or_else(|| Ok(Vec::new()), read)
    }

    /// Writes one of the formats that have a file for each frame.
    fn write_frame(
        &self,
        format: Format,
        frame: &Frame,
        objects: &[Placed],
    ) -> Result<(), SimError> {
        match format {
            Format::Hair => {
                save(&self.file(frame.index, "hair"), |to| export::hair::write(to, frame))
            }
            Format::Pov => {
                save(&self.file(frame.index, "pov"), |to| export::pov::write(to, frame, objects))
            }
            Format::Mitsuba => self.write_mitsuba(frame, objects),
            Format::Usd => Ok(()),
        }
    }

    /// Writes a scene of Mitsuba, last of its files, so that all are there if it is.
    fn write_mitsuba(&self, frame: &Frame, objects: &[Placed]) -> Result<(), SimError> {
        let index = frame.index;
        let of_objects = self.show.objects.file(index).unwrap_or(index);
        let [curves, surfaces] = [frame_name(index, "txt"), objects_name(of_objects, "obj")];
        if of_objects == index && !objects.is_empty() {
            save(&self.folder.join(&surfaces), |to| export::obj::write_objects(to, objects))?;
        }
        save(&self.folder.join(&curves), |to| mitsuba::write_curves(to, frame))?;
        // All are in one folder.
        let beside = |name| Path::new(name).file_name().and_then(OsStr::to_str).unwrap_or(name);
        let files = mitsuba::SceneFiles { curves: beside(&curves), objects: beside(&surfaces) };
        // A scene says nothing of how its hair looks.
        let brown = EUMELANIN * Pigments::BROWN.eumelanin;
        let look = mitsuba::MitsubaHair::usual(brown.into());
        save(&self.file(index, "xml"), |to| mitsuba::write(to, frame, objects, &look, files))
    }

    /// Writes what is missing of those.
    fn write_missing(&self, format: Format, index: usize) -> Result<(), SimError> {
        let extension = match format {
            Format::Hair => "hair",
            Format::Pov => "pov",
            Format::Mitsuba => "xml",
            Format::Usd => return Ok(()),
        };
        if self.file(index, extension).is_file() {
            return Ok(());
        }
        let path = self.file(index, "vtp");
        let frame = self.open_frame(index).and_then(|mut file| export::vtp::read(&mut file));
        let frame = frame.map_err(SimError::export(&path))?;
        let objects = self.read_objects(index).map_err(SimError::export(&path))?;
        self.write_frame(format, &frame, &objects)
    }

    /// Writes the USD stage, of those layers that can be written.
    fn write_usd(&self) -> Vec<SimError> {
        let timeline = usd::Timeline {
            frames: self.count,
            rate: self.plan.frame_rate,
            end: self.plan.frame_time(self.count.saturating_sub(1) as u64),
        };
        let strands = self.write_strands(timeline);
        let objects = (self.show.objects != Objects::None).then(|| self.write_objects(&timeline));
        let layers = [(self.show.scenery.layer.0, Some(strands)), (OBJECTS_USD, objects)];
        let (mut written, mut faults) = (Vec::new(), Vec::new());
        for (layer, result) in layers {
            match result {
                Some(Ok(())) => written.push(layer),
                Some(Err(fault)) => faults.push(fault),
                None => (),
            }
        }
        if !written.is_empty() {
            let root = save(&self.folder.join(STAGE), |to| usd::root(to, &timeline, &written));
            faults.extend(root.err());
        }
        faults
    }

    fn write_strands(&self, timeline: usd::Timeline) -> Result<(), SimError> {
        let (layer, scope) = self.show.scenery.layer;
        let path = self.folder.join(layer);
        let prims = self.show.scenery.prims.clone();
        let strands = usd::Strands::new(timeline, scope, prims, |index| self.open_frame(index))
            .map_err(SimError::export(&path))?;
        let clip = |frames: Range<usize>| {
            let file = frame_name(frames.start, "usda");
            (frames, file)
        };
        let files: Vec<_> = strands.clips(LARGEST).into_iter().map(clip).collect();
        if files.is_empty() {
            return save(&path, |to| strands.write(to, None));
        }
        for (frames, file) in &files {
            save(&self.folder.join(file), |to| strands.write_clip(to, frames.clone()))?;
        }
        let clips = usd::Clips { manifest: MANIFEST.to_owned(), files };
        save(&self.folder.join(&clips.manifest), |to| strands.write_manifest(to))?;
        save(&path, |to| strands.write(to, Some(&clips)))
    }

    fn write_objects(&self, timeline: &usd::Timeline) -> Result<(), SimError> {
        save(&self.folder.join(OBJECTS_USD), |to| {
            let files = (0..self.count).filter(|&i| self.show.objects.file(i) == Some(i));
            let poses = |file| export::surface::read_poses(&mut self.open_objects(file)?);
            let poses: Vec<Vec<Isometry3<f64>>> = files.map(poses).collect::<Result<_, _>>()?;
            usd::objects(to, timeline, &self.read_objects(0)?, &poses)
        })
    }

    fn write_preview(&self) -> Result<(), SimError> {
        let shown = self.count.min(PREVIEW_FRAMES);
        let indices = || (0..shown).map(|i| i * (self.count - 1) / (shown - 1).max(1));
        save(&self.folder.join(PREVIEW), |to| {
            let picture = |index| -> Result<PreviewFrame, StudioError> {
                let frame = export::vtp::read(&mut self.open_frame(index)?)?;
                let supports = self.show.supports(frame.time);
                Ok(PreviewFrame::new(frame, supports)?)
            };
            let frames = indices().map(picture).collect::<Result<Vec<_>, _>>()?;
            let shown = indices().filter_map(|index| self.show.objects.file(index));
            let mut files: Vec<_> = shown.collect();
            // One is for all frames.
            files.dedup();
            let objects = files.into_iter().map(|file| self.read_objects(file));
            let objects = objects.collect::<Result<Vec<_>, _>>()?;
            let winds: Vec<_> = frames.iter().map(|frame| self.show.wind.at(frame.time)).collect();
            sheet::write(to, &frames, &objects, &winds)
        })
    }
}

impl Observer for FrameWriter {
    fn observe(&mut self, world: &World) -> Result<(), SimError> {
        if !self.plan.is_frame(world.steps()) {
            return Ok(());
        }
        let (index, time) = (self.count, world.time());
        let objects: Vec<_> = world.surfaces().collect();
        let file = self.show.objects.file(index).filter(|&file| file == index);
        if let Some(file) = file {
            let path = self.folder.join(objects_name(file, "vtp"));
            save(&path, |to| export::surface::write(to, time, &objects))?;
        }
        let counts = world.stepper().strand_nodes();
        save(&self.file(index, "vtp"), |to| {
            export::vtp::write_strands(to, (index, time), &counts, world.stepper().strands())
        })?;
        if self.show.formats.iter().any(|format| *format != Format::Usd) {
            let frame = Frame { index, time, strands: world.stepper().strands().collect() };
            for format in &self.show.formats {
                // What fails is tried again at the end, and told then.
                let _ = self.write_frame(*format, &frame, &objects);
            }
        }
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

    fn finish(&mut self) -> Vec<SimError> {
        let formats = &self.show.formats;
        let files = (0..self.count).flat_map(|i| formats.iter().map(move |format| (*format, i)));
        let missing = files.map(|(format, index)| self.write_missing(format, index));
        let mut faults: Vec<_> =
            [self.write_pvd()].into_iter().chain(missing).filter_map(Result::err).collect();
        if formats.contains(&Format::Usd) {
            faults.extend(self.write_usd());
        }
        faults.extend(self.write_preview().err());
        faults
    }
}
