use super::Observer;
use super::probes::{probe_columns, read_probes};
use crate::scene::Probe;
use crate::{Plan, SimError, Stepper, World};
use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A CSV file with a row at regular steps; its first column is the time.
///
/// Rows are appended as wholes, so that the file can be watched while it grows.
pub(crate) struct CsvTable {
    path: PathBuf,
    file: File,
    header: String,
    row: RowReader,
    /// Has a row when a record is due.
    plan: Plan,
    /// Rows that are not in the file yet.
    pending: String,
    /// Length of the file, bytes.
    length: u64,
}

/// The numbers of a row after its time.
type RowReader = Box<dyn Fn(&World) -> Vec<f64>>;

/// Pending rows are written when they are longer than this, bytes.
const BUFFER: usize = 1 << 16;

impl CsvTable {
    /// Kinetic, elastic, gravitational energy and their sum, and what a stepper adds to them.
    pub(crate) fn energies(
        path: &Path,
        stepper: &dyn Stepper,
        plan: Plan,
    ) -> Result<Self, SimError> {
        let names = ["kinetic (J)", "elastic (J)", "gravitational (J)", "total (J)"];
        let names = names.map(str::to_owned).into_iter().chain(stepper.energy_columns());
        let row = |world: &World| {
            let energy = world.energy();
            let mut row =
                vec![energy.kinetic, energy.elastic, energy.gravitational, energy.total()];
            row.extend(world.stepper().energy_row());
            row
        };
        Self::open(path, names, Box::new(row), plan)
    }

    /// Table number `table` of a stepper, with these columns.
    pub(crate) fn of_stepper(
        path: &Path,
        table: usize,
        columns: Vec<String>,
        plan: Plan,
    ) -> Result<Self, SimError> {
        let row = move |world: &World| world.stepper().row(table);
        Self::open(path, columns, Box::new(row), plan)
    }

    /// What probes read.
    pub(crate) fn probes(path: &Path, probes: &[Probe], plan: Plan) -> Result<Self, SimError> {
        let (names, probes) = (probes.iter().flat_map(probe_columns), probes.to_vec());
        let row = move |world: &World| read_probes(&probes, world);
        Self::open(path, names, Box::new(row), plan)
    }

    /// Opens the file of a table without changing it; [`Observer::rewind`] says where to begin.
    fn open(
        path: &Path,
        names: impl IntoIterator<Item = String>,
        row: RowReader,
        plan: Plan,
    ) -> Result<Self, SimError> {
        let file = File::options()
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(SimError::io("write", path))?;
        let names: String = names.into_iter().map(|name| format!(",{name}")).collect();
        let header = format!("time (s){names}\n");
        let pending = String::new();
        Ok(Self { path: path.to_owned(), file, header, row, plan, pending, length: 0 })
    }

    fn flush(&mut self) -> Result<(), SimError> {
        self.file.write_all(self.pending.as_bytes()).map_err(SimError::io("write", &self.path))?;
        self.length += self.pending.len() as u64;
        self.pending.clear();
        Ok(())
    }
}

impl Observer for CsvTable {
    fn observe(&mut self, world: &World) -> Result<(), SimError> {
        if !self.plan.is_record(world.steps()) {
            return Ok(());
        }
        self.pending += &format!("{:?}", world.time());
        for x in (self.row)(world) {
            self.pending += &format!(",{x:?}");
        }
        self.pending.push('\n');
        if self.pending.len() > BUFFER { self.flush() } else { Ok(()) }
    }

    fn mark(&mut self) -> Result<u64, SimError> {
        self.flush()?;
        Ok(self.length)
    }

    fn list(&mut self) -> Result<(), SimError> {
        Ok(())
    }

    /// The file itself stays open.
    fn relocate(&mut self, folder: &Path) {
        self.path = folder.join(self.path.file_name().unwrap_or_default());
    }

    fn rewind(&mut self, mark: u64) -> Result<(), SimError> {
        let length = self.file.metadata().map_err(SimError::io("read", &self.path))?.len();
        if length < mark {
            let why = format!(
                "does not fit the folder: {} is shorter than it was; force a new run",
                self.path.display()
            );
            return Err(SimError::Checkpoint { path: self.path.clone(), why });
        }
        self.file
            .set_len(mark)
            .and_then(|()| self.file.seek(SeekFrom::Start(mark)))
            .map_err(SimError::io("write", &self.path))?;
        self.length = mark;
        self.pending.clear();
        if mark == 0 {
            self.pending += &self.header;
        }
        Ok(())
    }
}
