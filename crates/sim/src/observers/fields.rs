use super::Observer;
use crate::folder::{FRAMES, RunFolder};
use crate::storage::save;
use crate::{SimError, World};
use rapunzel_electrostatics::FieldGrid;
use std::path::PathBuf;

/// Writes the electric field on a grid as a VTK image with every frame.
#[derive(Debug)]
pub(crate) struct FieldWriter {
    folder: PathBuf,
    grid: FieldGrid,
    /// Steps between frames.
    every: u64,
}

impl FieldWriter {
    /// The folder of the frames must be there.
    pub(crate) fn new(folder: &RunFolder, grid: FieldGrid, every: u64) -> Self {
        Self { folder: folder.file(FRAMES), grid, every }
    }
}

impl Observer for FieldWriter {
    fn observe(&mut self, world: &World) -> Result<(), SimError> {
        if !world.steps().is_multiple_of(self.every) {
            return Ok(());
        }
        let fields = world.electric_fields(&self.grid.points())?;
        let name = format!("field-{:06}.vti", world.steps() / self.every);
        save(&self.folder.join(name), |to| {
            self.grid.write_vti(to, &fields).map_err(|error| std::io::Error::other(error).into())
        })
    }

    // Every file is written as a whole, and again when a run goes on from before it.
    fn mark(&mut self) -> Result<u64, SimError> {
        Ok(0)
    }

    fn sync(&mut self) -> Result<(), SimError> {
        Ok(())
    }

    fn rewind(&mut self, _: u64) -> Result<(), SimError> {
        Ok(())
    }

    fn finish(&mut self) -> Result<(), SimError> {
        Ok(())
    }
}
