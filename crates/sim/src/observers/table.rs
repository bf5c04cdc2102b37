use super::Observer;
use crate::scene::{Node, Probe, Quantity};
use crate::{Plan, SimError, Works, World};
use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A CSV file with a row at regular steps; its first column is the time.
///
/// Rows are appended as wholes, so that the file can be watched while it grows.
#[derive(Debug)]
pub(crate) struct Table {
    path: PathBuf,
    file: File,
    header: String,
    columns: Vec<Column>,
    /// Has a row when a record is due.
    plan: Plan,
    /// Rows that are not in the file yet.
    pending: String,
    /// Length of the file, bytes.
    length: u64,
}

/// One or several numbers of a row.
#[derive(Debug, Clone)]
pub(crate) enum Column {
    /// Kinetic, elastic, gravitational energy and their sum.
    Energies,
    /// Work of contacts since the start: see [`crate::ContactWork`].
    ContactWork,
    /// All other work since the start.
    Works,
    /// What a mass-spring system shows besides, by the names with their units.
    Springs(Vec<String>),
    /// What a probe reads.
    Probe(Probe),
    /// What the contacts of the last step were and cost.
    Contacts,
    /// Force of all fibres on an object, by its index.
    ObjectForce(usize),
    /// How charged fibres came to rest in the last step.
    Charge,
}

/// Pending rows are written when they are longer than this, bytes.
const BUFFER: usize = 1 << 16;

impl Table {
    /// Opens the file of a table without changing it; [`Observer::rewind`] says where to begin.
    pub(crate) fn open(path: &Path, columns: Vec<Column>, plan: Plan) -> Result<Self, SimError> {
        let file = File::options()
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(SimError::io("write", path))?;
        let names: String = columns.iter().map(|c| c.names()).collect();
        let header = format!("time (s){names}\n");
        let pending = String::new();
        Ok(Self { path: path.to_owned(), file, header, columns, plan, pending, length: 0 })
    }

    fn flush(&mut self) -> Result<(), SimError> {
        self.file.write_all(self.pending.as_bytes()).map_err(SimError::io("write", &self.path))?;
        self.length += self.pending.len() as u64;
        self.pending.clear();
        Ok(())
    }
}

impl Observer for Table {
    fn observe(&mut self, world: &World) -> Result<(), SimError> {
        if !self.plan.is_record(world.steps()) {
            return Ok(());
        }
        self.pending += &format!("{:?}", world.time());
        for column in &self.columns {
            for x in column.read(world) {
                self.pending += &format!(",{x:?}");
            }
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

impl Column {
    /// The names with their units, each after a comma.
    fn names(&self) -> String {
        match self {
            Self::Energies => ",kinetic (J),elastic (J),gravitational (J),total (J)".to_owned(),
            Self::ContactWork => {
                ",work of friction (J),work of closing (J),work of gap repair (J),\
                                  work of restitution (J),work of adhesion (J),\
                                  work of compliance (J),work of led objects (J)"
                    .to_owned()
            }
            Self::Works => ",work of gravity (J),work of loads (J),work of drag (J),\
                            work of damping (J),work of supports (J),work of the integrator (J),\
                            work of the solver (J)"
                .to_owned(),
            Self::Springs(names) => names.iter().map(|name| format!(",{name}")).collect(),
            Self::Probe(Probe { fiber, node, quantity }) => {
                let node = match node {
                    Node::Tip => "tip".to_owned(),
                    Node::At { index } => format!("node {index}"),
                };
                let (symbol, unit) = match quantity {
                    Quantity::Position => ("", "m"),
                    Quantity::Velocity => ("v", "m/s"),
                };
                let name = |axis| format!(",fiber {fiber} {node} {symbol}{axis} ({unit})");
                ["x", "y", "z"].map(name).concat()
            }
            Self::Contacts => ",listed,active,parts,lists,solves,iterations,unresolved,residual,\
                normal error (m/s),slip error (m/s),depth (m)"
                .to_owned(),
            Self::Charge => {
                ",charge (C),drained (C),electric (J),mean field (V/m),lift,evaluations,\
                retreats,unsettled,residual"
                    .to_owned()
            }
            Self::ObjectForce(object) => {
                ["x", "y", "z"].map(|axis| format!(",objects[{object}] force {axis} (N)")).concat()
            }
        }
    }

    fn read(&self, world: &World) -> Vec<f64> {
        match self {
            Self::Energies => {
                let energy = world.energy();
                vec![energy.kinetic, energy.elastic, energy.gravitational, energy.total()]
            }
            Self::ContactWork => {
                let work = world.contact_work();
                vec![
                    work.friction,
                    work.closing,
                    work.repair,
                    work.restitution,
                    work.adhesion,
                    work.compliance,
                    work.led,
                ]
            }
            Self::Works => {
                let works = world.works().unwrap_or_default();
                let Works { gravity, loads, drag, damping, supports, integrator, solver } = works;
                vec![gravity, loads, drag, damping, supports, integrator, solver]
            }
            Self::Springs(_) => {
                world.springs.as_ref().map(|springs| springs.readings()).unwrap_or_default()
            }
            Self::Probe(probe) => {
                let node = match probe.node {
                    Node::Tip => None,
                    Node::At { index } => Some(index),
                };
                let (position, velocity) = world.node(probe.fiber, node);
                let value = match probe.quantity {
                    Quantity::Position => position.coords,
                    Quantity::Velocity => velocity,
                };
                value.iter().copied().collect()
            }
            Self::Contacts => {
                let of = &world.contacts.report;
                let counts = [of.listed, of.active, of.parts, of.lists, of.solves, of.iterations];
                let counts = counts.into_iter().chain([of.unresolved]).map(|count| count as f64);
                let errors = [of.residual, of.normal_error, of.slip_error, of.depth];
                counts.chain(errors).collect()
            }
            Self::Charge => {
                let of = world.charge_report().unwrap_or_default();
                let counts = [of.evaluations, of.retreats, of.unsettled].map(|n| n as f64);
                let sizes = [of.charge, of.drained, of.energy, of.mean_field, of.lift];
                sizes.into_iter().chain(counts).chain([of.residual]).collect()
            }
            Self::ObjectForce(object) => world.force_on(*object).iter().copied().collect(),
        }
    }
}
