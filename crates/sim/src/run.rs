use crate::checkpoint::{Checkpoint, scene_hash};
use crate::folder::{CHARGE, CHECKPOINT, CONTACTS, ENERGIES, OBJECTS, PROBES, RunFolder, SCENE};
use crate::observers::{Column, FieldWriter, FrameWriter, Observer, Shown, Table};
use crate::storage::{partial, put_in_place, write_atomically};
use crate::{
    Outcome, Plan, Scene, SimError, Statistics, Stepper, Stopwatch, Summary, World, mass_spring,
};
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

/// How a run is watched and stopped.
pub struct Control<'a> {
    /// Frames from checkpoint to checkpoint.
    pub checkpoint_every: u64,
    /// Stops the run with a checkpoint after the step at hand, once it is true.
    pub cancel: &'a AtomicBool,
    /// Called at the start and after every step.
    pub progress: &'a mut dyn FnMut(&Progress),
    /// By which the statistics tell what phases took.
    pub stopwatch: Option<Stopwatch>,
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

/// Runs a scene in a folder, from its checkpoint if there is one and from its start if not.
///
/// The contents of all files depend on the scene alone, not on the number of threads nor on
/// interruptions; only `run.log`, which this function does not write, tells of them.
///
/// # Errors
/// [`SimError`]; where a step could not be taken, the last checkpoint is that of the frame before.
/// After every error a run can be resumed once its cause is removed.
pub fn run(scene: &Scene, folder: &RunFolder, control: Control) -> Result<Summary, SimError> {
    let mut run = Run::start(scene, folder)?;
    let result = run.go(control);
    let outcome = match &result {
        Ok(outcome) => outcome.clone(),
        Err(error) => Outcome::Failed { error: error.to_string() },
    };
    let summary = run.summary(outcome);
    // Of an error in the run and one in telling of it, the first is the one to report.
    let written = summary.write(folder);
    result.and(written).map(|()| summary)
}

struct Run<'a> {
    scene: &'a Scene,
    folder: &'a RunFolder,
    plan: Plan,
    world: World,
    stepper: Box<dyn Stepper>,
    statistics: Statistics,
    observers: Vec<Box<dyn Observer>>,
    /// Of the scene.
    hash: [u8; 32],
    /// Whether the run at the last frame waits beside the checkpoint, to take its place.
    remembered: bool,
}

impl<'a> Run<'a> {
    fn start(scene: &'a Scene, folder: &'a RunFolder) -> Result<Self, SimError> {
        let plan = Plan::new(scene);
        let mut world = scene.build()?;
        let stepper = scene.stepper_of(&world)?;
        let mut observers = observers(scene, folder, &plan)?;
        let hash = scene_hash(scene)?;
        let last = Checkpoint::read(&folder.file(CHECKPOINT))?;
        let statistics = last.as_ref().map_or_else(Statistics::default, |last| last.statistics);
        let fresh = last.is_none();
        if let Some(last) = last {
            if last.scene != hash {
                return Err(SimError::DifferentScene(folder.path().to_owned()));
            }
            world.restore(&last.snapshot)?;
            if scene.charging.is_some() {
                let time = world.time();
                scene.load_at(&mut world, time)?;
            }
            for (observer, mark) in observers.iter_mut().zip(&last.marks) {
                observer.rewind(*mark)?;
            }
        } else {
            let text = scene.to_ron()?;
            write_atomically(&folder.file(SCENE), |to| to.write_all(text.as_bytes()))?;
            for observer in &mut observers {
                observer.rewind(0)?;
                observer.observe(&world)?;
            }
        }
        let remembered = false;
        let mut run =
            Self { scene, folder, plan, world, stepper, statistics, observers, hash, remembered };
        if fresh {
            run.remember()?;
        }
        Ok(run)
    }

    fn go(&mut self, control: Control) -> Result<Outcome, SimError> {
        let Control { checkpoint_every, cancel, progress, stopwatch } = control;
        self.world.set_stopwatch(stopwatch);
        progress(&self.progress());
        self.save()?;
        while self.world.steps() < self.plan.steps {
            if cancel.load(Ordering::Relaxed) {
                self.remember()?;
                self.save()?;
                return Ok(Outcome::Cancelled);
            }
            if let Err(error) = self.step() {
                // On a full disk saving fails too; then the checkpoint before stays, and the
                // error to report is still the first.
                let _ = self.go_back().and_then(|()| self.save());
                return Err(error);
            }
            if self.world.steps().is_multiple_of(self.plan.steps_per_frame) {
                self.remember()?;
                let frame = self.world.steps() / self.plan.steps_per_frame;
                if frame.is_multiple_of(checkpoint_every) {
                    self.save()?;
                }
            }
            progress(&self.progress());
        }
        self.remember()?;
        self.save()?;
        self.observers.iter_mut().try_for_each(|observer| observer.finish())?;
        Ok(Outcome::Complete)
    }

    fn step(&mut self) -> Result<(), SimError> {
        let report = self.stepper.step(&mut self.world, self.plan.dt)?;
        self.statistics.add(&report);
        self.observers.iter_mut().try_for_each(|observer| observer.observe(&self.world))
    }

    /// Goes back to where the run was last remembered.
    fn go_back(&mut self) -> Result<(), SimError> {
        let checkpoint = self.folder.file(CHECKPOINT);
        let path = if self.remembered { partial(&checkpoint) } else { checkpoint };
        let Some(last) = Checkpoint::read(&path)? else { return Ok(()) };
        self.statistics = last.statistics;
        self.world.restore(&last.snapshot)
    }

    /// Remembers the run as it is now, in a file that the next checkpoint is made of.
    fn remember(&mut self) -> Result<(), SimError> {
        let marks = self.observers.iter_mut().map(|observer| observer.mark());
        let marks = marks.collect::<Result<_, _>>()?;
        let (snapshot, statistics) = (self.world.present(), self.statistics);
        let now = Checkpoint { scene: self.hash, snapshot, statistics, marks };
        now.prepare(&self.folder.file(CHECKPOINT))?;
        self.remembered = true;
        Ok(())
    }

    /// Makes what was last remembered the checkpoint: the outputs first, so that it never knows more
    /// than they hold.
    fn save(&mut self) -> Result<(), SimError> {
        self.observers.iter_mut().try_for_each(|observer| observer.sync())?;
        if std::mem::take(&mut self.remembered) {
            put_in_place(&self.folder.file(CHECKPOINT))?;
        }
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

fn observers(
    scene: &Scene,
    folder: &RunFolder,
    plan: &Plan,
) -> Result<Vec<Box<dyn Observer>>, SimError> {
    let output = &scene.output;
    let every = plan.steps_per_record;
    let interval = plan.dt * plan.steps_per_frame as f64;
    let shown = Shown::of(&scene.objects);
    let wind = scene.mass_spring.as_ref().map_or(scene.environment.wind, |springs| springs.wind);
    let (formats, every_frame) = (&output.formats, plan.steps_per_frame);
    let frames = FrameWriter::open(folder, formats, shown, wind, every_frame, interval)?;
    let readings = scene.mass_spring.as_ref().map(mass_spring::readings);
    let work = scene.contact.as_ref().map(|_| Column::ContactWork);
    let works = output.ledger.then_some(Column::Works);
    let columns = [Column::Energies].into_iter().chain(work).chain(works);
    let columns = columns.chain(readings.map(Column::Springs)).collect();
    let energies = Table::open(&folder.file(ENERGIES), columns, every)?;
    let mut observers: Vec<Box<dyn Observer>> = vec![Box::new(frames), Box::new(energies)];
    if scene.contact.is_some() {
        let file = folder.file(CONTACTS);
        observers.push(Box::new(Table::open(&file, vec![Column::Contacts], every)?));
    }
    if let Some(grid) = scene.charging.as_ref().and_then(|charging| charging.grid) {
        observers.push(Box::new(FieldWriter::new(folder, grid.into(), every_frame)));
    }
    if scene.charging.is_some() {
        let file = folder.file(CHARGE);
        observers.push(Box::new(Table::open(&file, vec![Column::Charge], every)?));
    }
    if !output.probes.is_empty() {
        let columns = output.probes.iter().map(|probe| Column::Probe(*probe)).collect();
        observers.push(Box::new(Table::open(&folder.file(PROBES), columns, every)?));
    }
    if scene.contact.is_some() && !scene.objects.is_empty() {
        let columns = (0..scene.objects.len()).map(Column::ObjectForce).collect();
        observers.push(Box::new(Table::open(&folder.file(OBJECTS), columns, every)?));
    }
    Ok(observers)
}
