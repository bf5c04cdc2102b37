use crate::folder::{RunFolder, SUMMARY};
use crate::scene::Format;
use crate::storage::replace;
use crate::{ChargeReport, ContactReport, ContactTimes, Plan, Scene, SimError, StepReport, World};
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::{self, Write};
use std::path::Path;

/// What the steps of a run have cost so far.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Statistics {
    /// Newton iterations, over all steps and fibres.
    pub iterations: u64,
    /// Steps of single fibres.
    pub fiber_steps: u64,
    /// Iterations of the worst step of a fibre.
    pub worst_iterations: u64,
    /// How often the step of a fibre was halved because Newton's method failed.
    pub halvings: u64,
    /// How often a step missed its tolerance although it was the smallest.
    pub missed: u64,
    /// What the contacts were and cost.
    #[serde(default)]
    pub contact: ContactReport,
    /// What their phases took since the program began.
    #[serde(skip)]
    pub contact_times: ContactTimes,
    /// How charged fibres came to rest, if there are any.
    #[serde(default)]
    pub charge: ChargeReport,
}

impl Statistics {
    /// Counts a step, in which charged fibres came to rest so.
    pub(crate) fn add(&mut self, report: &StepReport, charge: Option<ChargeReport>) {
        self.iterations += report.iterations as u64;
        self.fiber_steps += report.fibers as u64;
        self.worst_iterations = self.worst_iterations.max(report.worst_iterations as u64);
        self.halvings += report.halvings as u64;
        self.missed += report.missed as u64;
        self.contact.add(&report.contact);
        self.contact_times += report.contact_times;
        self.charge.add(&charge.unwrap_or_default());
    }

    /// Mean number of iterations in a step of a fibre.
    #[must_use]
    pub fn mean_iterations(&self) -> f64 {
        self.iterations as f64 / self.fiber_steps.max(1) as f64
    }
}

/// How a run stands.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// Not at its end; it runs, or it was killed and can be resumed.
    Unfinished,
    /// At its end, with all its files.
    Complete,
    /// Stopped by the user; it can be resumed.
    Cancelled,
    /// Stopped by an error.
    Failed {
        /// The error.
        error: String,
    },
}

/// What a format that a scene asks for cannot hold of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LeftOut {
    /// Objects: `.hair` has nothing but strands.
    ObjectsInHair,
}

/// The contents of `summary.json`: nothing that depends on the computer or on interruptions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// How the run stands.
    pub outcome: Outcome,
    /// Title of the scene.
    pub scene: String,
    /// Version of the program.
    pub version: String,
    /// Number of fibres.
    pub fibers: usize,
    /// Number of nodes of all fibres.
    pub nodes: usize,
    /// Time step taken, s.
    pub dt: f64,
    /// Steps taken.
    pub steps: u64,
    /// Steps of the whole run.
    pub planned_steps: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Frames written.
    pub frames: u64,
    /// What its formats leave out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<LeftOut>,
    /// Mean number of Newton iterations in a step of a fibre.
    pub mean_iterations: f64,
    /// Largest number of them.
    pub worst_iterations: u64,
    /// How often a step was halved because Newton's method failed.
    pub halvings: u64,
    /// How often a step missed its tolerance although it was the smallest.
    pub missed: u64,
    /// What the contacts were and cost, if the scene has any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact: Option<ContactReport>,
    /// How charged fibres came to rest, if the scene has any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub charge: Option<ChargeReport>,
    /// Kinetic energy of all fibres, J.
    pub kinetic_energy: f64,
    /// Elastic energy of all fibres, J.
    pub elastic_energy: f64,
    /// Energy of all fibres in gravity, zero at the world's origin, J.
    pub gravitational_energy: f64,
    /// The sum of the three, J.
    pub total_energy: f64,
}

impl Summary {
    pub(crate) fn new(
        outcome: Outcome,
        scene: &Scene,
        plan: &Plan,
        world: &World,
        statistics: &Statistics,
    ) -> Self {
        let energy = world.energy();
        let of_hair = scene.output.formats.contains(&Format::Hair) && !scene.objects.is_empty();
        let left_out = of_hair.then_some(LeftOut::ObjectsInHair).into_iter().collect();
        Self {
            outcome,
            scene: scene.name.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            fibers: world.assembly().fibers().len(),
            nodes: world.nodes(),
            dt: plan.dt,
            steps: world.steps(),
            planned_steps: plan.steps,
            time: world.time(),
            frames: 1 + plan.frames_after(world.steps()),
            left_out,
            mean_iterations: statistics.mean_iterations(),
            worst_iterations: statistics.worst_iterations,
            halvings: statistics.halvings,
            missed: statistics.missed,
            contact: scene.contact.is_some().then_some(statistics.contact),
            charge: scene.charging.is_some().then_some(statistics.charge),
            kinetic_energy: energy.kinetic,
            elastic_energy: energy.elastic,
            gravitational_energy: energy.gravitational,
            total_energy: energy.total(),
        }
    }

    pub(crate) fn write(&self, folder: &RunFolder) -> Result<(), SimError> {
        replace(&folder.file(SUMMARY), |to| {
            serde_json::to_writer_pretty(&mut *to, self)?;
            to.write_all(b"\n")
        })
    }

    /// Reads the summary of the run in a folder.
    ///
    /// # Errors
    /// [`SimError::NoRun`] if there is none, [`SimError::Io`] if it cannot be read or is damaged.
    pub fn read(folder: &Path) -> Result<Self, SimError> {
        let path = folder.join(SUMMARY);
        let text = fs::read_to_string(&path).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => {
                SimError::NoRun(folder.to_owned())
            }
            _ => SimError::io("read", &path)(error),
        })?;
        serde_json::from_str(&text).map_err(|error| {
            let why = format!("{error}; resume the run, which writes it anew");
            SimError::io("read", &path)(io::Error::other(why))
        })
    }
}
