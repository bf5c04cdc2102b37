use super::Observer;
use crate::folder::{FRAMES, RunFolder};
use crate::manifest::Entry;
use crate::storage::save;
use crate::{Plan, SimError, World};
use rapunzel_electrostatics::FieldGrid;
use std::path::{Path, PathBuf};

/// Writes the electric field on a grid as a VTK image with every frame.
#[derive(Debug)]
pub(crate) struct FieldWriter {
    folder: PathBuf,
    grid: FieldGrid,
    plan: Plan,
}

impl FieldWriter {
    /// The files of a run with so many frames.
    pub(crate) fn files(frames: u64) -> Entry {
        Entry::series(&format!("{FRAMES}/field"), "vti", frames)
    }

    /// The folder of the frames must be there.
    pub(crate) fn new(folder: &RunFolder, grid: FieldGrid, plan: Plan) -> Self {
        Self { folder: folder.file(FRAMES), grid, plan }
    }
}

impl Observer for FieldWriter {
    fn observe(&mut self, world: &World) -> Result<(), SimError> {
        if !self.plan.is_frame(world.steps()) {
            return Ok(());
        }
        let fields = world.electric_fields(&self.grid.points())?;
        let name = format!("field-{:06}.vti", self.plan.frames_after(world.steps()));
        save(&self.folder.join(name), |to| {
            self.grid.write_vti(to, &fields).map_err(std::io::Error::other)
        })
    }

    // Every file is written as a whole, and again when a run goes on from before it.
    fn mark(&mut self) -> Result<u64, SimError> {
        Ok(0)
    }

    fn list(&mut self) -> Result<(), SimError> {
        Ok(())
    }

    fn relocate(&mut self, folder: &Path) {
        self.folder = folder.join(FRAMES);
    }

    fn rewind(&mut self, _: u64) -> Result<(), SimError> {
        Ok(())
    }
}
