//! What looks at a world while it moves, and never changes it.

mod fields;
mod frames;
mod plots;
mod probes;
mod show;
mod table;

pub(crate) use fields::FieldWriter;
pub(crate) use frames::FrameWriter;
pub(crate) use plots::PlotWriter;
pub(crate) use show::{Objects, Show};
pub(crate) use table::CsvTable;

use crate::{SimError, World};
use std::path::Path;

/// Looks at a world at the start and after every step.
pub(crate) trait Observer {
    /// Takes note of the world, if it is time to.
    fn observe(&mut self, world: &World) -> Result<(), SimError>;

    /// How far the output has come.
    fn mark(&mut self) -> Result<u64, SimError>;

    /// Writes what tells of all that has been written so far.
    fn list(&mut self) -> Result<(), SimError>;

    /// Follows the files of the run, which have moved to another folder.
    fn relocate(&mut self, folder: &Path);

    /// Goes back to where [`Observer::mark`] was; to the very start for 0.
    fn rewind(&mut self, mark: u64) -> Result<(), SimError>;

    /// Writes what can be written only when all has been seen, and tells which files could not be.
    fn finish(&mut self) -> Vec<SimError> {
        Vec::new()
    }
}
