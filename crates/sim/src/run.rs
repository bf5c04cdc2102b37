use crate::checkpoint::{Checkpoint, scene_hash};
use crate::folder::{
    CHECKPOINT, ENERGIES, LOG, NEXT_CHECKPOINT, PLOTS, PROBES, RunFolder, SCENE, SUMMARY,
};
use crate::manifest::{Entry, Manifest};
use crate::observers::{CsvTable, FieldWriter, FrameWriter, Objects, Observer, PlotWriter, Show};
use crate::storage::{rename_durably, replace, sync};
use crate::{
    Outcome, Plan, Scene, SimError, Statistics, Stepper, Stopwatch, Summary, World, style,
};
use rapunzel_electrostatics::FieldGrid;
use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// How a run is watched and stopped.
pub struct Control<'a> {
    /// Asked at every frame whether the run is to be made safe from a loss of power; a kill costs
    /// no more than what was not yet a frame in any case.
    pub sync_is_due: &'a mut dyn FnMut() -> bool,
    /// Stops the run with a checkpoint after the step at hand, once it is asked to.
    pub cancel: &'a Cancel,
    /// Called at the start and after every step.
    pub progress: &'a mut dyn FnMut(&Progress),
    /// Stopwatch by which the statistics tell what phases took.
    pub stopwatch: Option<Stopwatch>,
}

/// By what a run is asked to stop, from any thread.
#[derive(Debug, Default)]
pub struct Cancel {
    asked: AtomicBool,
    heard: AtomicBool,
}

impl Cancel {
    /// A cancel that nobody has asked for yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { asked: AtomicBool::new(false), heard: AtomicBool::new(false) }
    }

    /// Asks the run to stop; true if it has been asked before.
    pub fn ask(&self) -> bool {
        self.asked.swap(true, Ordering::Relaxed)
    }

    /// Whether the run has heard that it is to stop, and is about to.
    #[must_use]
    pub fn is_heard(&self) -> bool {
        self.heard.load(Ordering::Relaxed)
    }

    /// Whether somebody has asked; whoever looks is about to stop.
    pub fn hear(&self) -> bool {
        let asked = self.asked.load(Ordering::Relaxed);
        self.heard.store(asked, Ordering::Relaxed);
        asked
    }
}

/// How far a run has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Steps taken.
    pub steps: u64,
    /// Steps of the whole run.
    pub planned_steps: u64,
    /// Simulated time, s.
    pub time: f64,
    /// What the steps have cost.
    pub statistics: Statistics,
}

/// Runs the `world` of a scene in a folder, from the checkpoint there if there is one and from its
/// start if not. The scene tells how long, in which steps and what is written; the world is what
/// [`World::build`] makes of it, or any other in which a [`Stepper`] of the caller's moves.
///
/// The contents of all files depend on the scene alone, not on the number of threads nor on
/// interruptions; only the log, which this function does not write, tells of them. An older run
/// that the folder was opened to overwrite is there until the new one has its first frame after the
/// start.
///
/// # Errors
/// [`SimError`]; where a step could not be taken, the last checkpoint is that of the frame before.
/// After every error a run that has a frame can be resumed once its cause is removed.
pub fn run(
    scene: &Scene,
    world: World,
    folder: &mut RunFolder,
    control: Control,
) -> Result<Summary, SimError> {
    let mut run = ActiveRun::start(scene, world, folder)?;
    let result = run.go(control);
    let outcome = match &result {
        Ok(outcome) => outcome.clone(),
        Err(error) => Outcome::Failed { error: error.to_string() },
    };
    let summary = run.summary(outcome);
    // Of an error in the run and one in telling of it, the first is the one to report.
    let written = summary.write(run.folder);
    result.and(written).map(|()| summary)
}

struct ActiveRun<'a> {
    scene: &'a Scene,
    folder: &'a mut RunFolder,
    plan: Plan,
    world: World,
    statistics: Statistics,
    observers: Vec<Box<dyn Observer>>,
    /// Hash of the scene.
    hash: [u8; 32],
}

impl<'a> ActiveRun<'a> {
    fn start(scene: &'a Scene, world: World, folder: &'a mut RunFolder) -> Result<Self, SimError> {
        let plan = Plan::new(scene);
        let hash = scene_hash(scene)?;
        let mut checkpoints = vec![folder.file(NEXT_CHECKPOINT), folder.file(CHECKPOINT)];
        checkpoints.retain(|path| path.exists());
        let fresh = checkpoints.is_empty();
        if fresh {
            style::files(scene)?.iter().for_each(|file| folder.protect(file));
            folder.begin(&files(scene, world.stepper(), &plan))?;
        } else {
            folder.go_on()?;
        }
        let observers = observers(scene, &world, folder, plan)?;
        let statistics = Statistics::default();
        let mut run = Self { scene, folder, plan, world, statistics, observers, hash };
        // Only a loss of power damages the newer one.
        let mut resumed = checkpoints.iter().map(|path| run.resume(path));
        match resumed.next() {
            None => run.begin()?,
            Some(first) => {
                first.or_else(|error| resumed.next().and_then(Result::ok).ok_or(error))?;
            }
        }
        Ok(run)
    }

    /// Writes what is known at the start.
    fn begin(&mut self) -> Result<(), SimError> {
        let text = self.scene.to_ron()?;
        replace(&self.folder.file(SCENE), |to| to.write_all(text.as_bytes()))?;
        for observer in &mut self.observers {
            observer.rewind(0)?;
            observer.observe(&self.world)?;
        }
        self.remember()
    }

    fn go(&mut self, control: Control) -> Result<Outcome, SimError> {
        let Control { sync_is_due, cancel, progress, stopwatch } = control;
        self.world.set_stopwatch(stopwatch);
        progress(&self.progress());
        self.tell()?;
        while self.world.steps() < self.plan.steps {
            if cancel.hear() {
                if !self.folder.holds_older_run() {
                    self.remember()?;
                    self.save()?;
                }
                return Ok(Outcome::Cancelled);
            }
            if let Err(error) = self.step() {
                // On a full disk saving fails too; then the checkpoint before stays, and the
                // error to report is still the first.
                let _ = self.go_back().and_then(|()| self.save());
                return Err(error);
            }
            if self.plan.is_frame(self.world.steps()) {
                self.remember()?;
                if self.folder.exchange()? {
                    let files = self.folder.files();
                    self.observers.iter_mut().for_each(|observer| observer.relocate(files));
                }
                if sync_is_due() {
                    self.save()?;
                }
            }
            progress(&self.progress());
        }
        self.save()?;
        let faults: Vec<_> = self.observers.iter_mut().flat_map(|one| one.finish()).collect();
        if faults.is_empty() { Ok(Outcome::Complete) } else { Err(SimError::Unwritten { faults }) }
    }

    fn step(&mut self) -> Result<(), SimError> {
        let dt = self.plan.step_after(self.world.steps());
        let report = self.world.step(dt)?;
        self.statistics.add(&report, self.world.charge_report());
        if self.plan.is_frame(self.world.steps()) {
            self.world.watch_energy()?;
        }
        self.observers.iter_mut().try_for_each(|observer| observer.observe(&self.world))
    }

    /// Goes back to where the run was last remembered.
    fn go_back(&mut self) -> Result<(), SimError> {
        let newer = self.folder.file(NEXT_CHECKPOINT);
        let path = if newer.exists() { newer } else { self.folder.file(CHECKPOINT) };
        let last = Checkpoint::read(&path)?;
        self.statistics = last.statistics;
        self.world.restore(&last.snapshot)
    }

    /// Goes on from a checkpoint, with all outputs.
    fn resume(&mut self, path: &Path) -> Result<(), SimError> {
        let last = Checkpoint::read(path)?;
        if last.scene != self.hash {
            return Err(SimError::DifferentScene(self.folder.path().to_owned()));
        }
        self.statistics = last.statistics;
        self.world.restore(&last.snapshot)?;
        let mut outputs = self.observers.iter_mut().zip(&last.marks);
        outputs.try_for_each(|(observer, mark)| observer.rewind(*mark))
    }

    /// Remembers the run as it is now, in the checkpoint that a kill leaves.
    fn remember(&mut self) -> Result<(), SimError> {
        let marks = self.observers.iter_mut().map(|observer| observer.mark());
        let marks = marks.collect::<Result<Vec<_>, _>>()?;
        let path = self.folder.file(NEXT_CHECKPOINT);
        Checkpoint::write(&self.world, self.hash, self.statistics, &marks, &path)
    }

    /// Makes what was last remembered the checkpoint that a loss of power leaves, once the outputs
    /// are on the disk, so that it never knows more than they hold.
    fn save(&mut self) -> Result<(), SimError> {
        self.tell()?;
        sync(self.folder.path())?;
        let newer = self.folder.file(NEXT_CHECKPOINT);
        if newer.exists() { rename_durably(&newer, &self.folder.file(CHECKPOINT)) } else { Ok(()) }
    }

    /// Writes how far the run has come.
    fn tell(&mut self) -> Result<(), SimError> {
        self.observers.iter_mut().try_for_each(|observer| observer.list())?;
        self.summary(Outcome::Unfinished).write(self.folder)
    }

    fn summary(&self, outcome: Outcome) -> Summary {
        Summary::new(outcome, self.scene, &self.plan, &self.world, &self.statistics)
    }

    fn progress(&self) -> Progress {
        Progress {
            steps: self.world.steps(),
            planned_steps: self.plan.steps,
            time: self.world.time(),
            statistics: self.statistics,
        }
    }
}

/// The files of a run.
fn files(scene: &Scene, stepper: &dyn Stepper, plan: &Plan) -> Manifest {
    let objects = Objects::of(&scene.objects);
    let mut files = FrameWriter::files(&scene.output.formats, objects, plan.frames());
    files.extend([SCENE, SUMMARY, CHECKPOINT, NEXT_CHECKPOINT, LOG].map(Entry::from));
    files.extend([ENERGIES, PLOTS].map(Entry::from));
    files.extend(stepper.tables().into_iter().map(|(name, _)| name.into()));
    files.extend((!scene.output.probes.is_empty()).then(|| PROBES.into()));
    files.extend(field_grid(scene).map(|_| FieldWriter::files(plan.frames())));
    files.into_iter().collect()
}

fn observers(
    scene: &Scene,
    world: &World,
    folder: &RunFolder,
    plan: Plan,
) -> Result<Vec<Box<dyn Observer>>, SimError> {
    let frames = FrameWriter::new(folder, Show::of(scene, world), plan);
    let mut observers: Vec<Box<dyn Observer>> = vec![Box::new(frames)];
    let (file, stepper) = (|name| folder.file(name), world.stepper());
    let mut names = vec![ENERGIES.to_owned()];
    let mut tables = vec![CsvTable::energies(&file(ENERGIES), stepper, plan)?];
    for (table, (name, columns)) in stepper.tables().into_iter().enumerate() {
        tables.push(CsvTable::of_stepper(&file(name), table, columns, plan)?);
        names.push(name.to_owned());
    }
    if !scene.output.probes.is_empty() {
        tables.push(CsvTable::probes(&file(PROBES), &scene.output.probes, plan)?);
        names.push(PROBES.to_owned());
    }
    observers.extend(tables.into_iter().map(|table| Box::new(table) as Box<dyn Observer>));
    if let Some(grid) = field_grid(scene) {
        observers.push(Box::new(FieldWriter::new(folder, grid, plan)));
    }
    observers.push(Box::new(PlotWriter::new(folder.files(), names)));
    Ok(observers)
}

fn field_grid(scene: &Scene) -> Option<FieldGrid> {
    scene.charging.as_ref()?.grid.map(Into::into)
}
