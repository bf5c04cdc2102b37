use crate::case_error::CaseError;
use rapunzel_charging::ChargingError;
use rapunzel_collision::CollisionError;
use rapunzel_contact::ContactError;
use rapunzel_coupling::CouplingError;
use rapunzel_fiber::FiberError;
use rapunzel_hairgen::HairgenError;
use rapunzel_keratin::KeratinError;
use rapunzel_mass_spring::SpringError;
use rapunzel_rod_dynamic::{EquilibriumError, RodError};
use rapunzel_rod_static::StaticError;
use rapunzel_scene::SceneError;
use rapunzel_strands::StrandsError;
use rapunzel_studio::StudioError;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What can go wrong between a scene file and its results.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SimError {
    /// The scene is not understood or asks for nonsense.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A hairstyle cannot grow.
    #[error("the style: {0}")]
    Hairstyle(#[from] HairgenError),
    /// Strands in a file cannot be read, or not be fibres.
    #[error("fibers[{bundle}], {}: {source}", path.display())]
    Strands {
        /// Index of the bundle in the scene.
        bundle: usize,
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: StrandsError,
    },
    /// Strands in a file cannot be read.
    #[error("{}: {source}", path.display())]
    StrandFile {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: StrandsError,
    },
    /// A folder with nothing to draw.
    #[error(
        "{} holds nothing to draw: give the folder of a run with frames or of a grown style, a scene, \
         a style, or a file of strands",
        path.display()
    )]
    Nothing {
        /// The folder.
        path: PathBuf,
    },
    /// Nothing of a groom is left.
    #[error(
        "fibers[{bundle}]: no strand of {} can be a fibre; look at its unit (`scale`) and at \
         `roots_within`",
        path.display()
    )]
    NoStrands {
        /// Index of the bundle in the scene.
        bundle: usize,
        /// The file.
        path: PathBuf,
    },
    /// A probe is at a node that a groom does not have.
    #[error(
        "output.probes[{probe}] is at a node of fibre {fiber} that is not there: of {fibers} fibres \
         this one has {nodes} nodes"
    )]
    Probe {
        /// Index of the probe in the scene.
        probe: usize,
        /// The fibre, counted over all bundles.
        fiber: usize,
        /// Number of all fibres.
        fibers: usize,
        /// Number of its nodes; 0 where there is no such fibre.
        nodes: usize,
    },
    /// A hand is at a node that is not there.
    #[error("grips[{grip}] is at a node of fibre {fiber} that is not there: it has {nodes} nodes")]
    Grip {
        /// Index of the hand in the scene.
        grip: usize,
        /// The fibre, counted over all bundles.
        fiber: usize,
        /// Number of its nodes; 0 where there is no such fibre.
        nodes: usize,
    },
    /// Hands are laid on what cannot be taken hold of.
    #[error("nothing here can be {0} by hand: fibres can be pulled, mass-spring systems also held")]
    NoHands(&'static str),
    /// An object is led by hand that moves freely, or that is not there.
    #[error("objects[{0}] cannot be led: it moves freely, or there is no such object")]
    Unled(usize),
    /// A fibre of the scene cannot be built although each of its numbers is in range.
    #[error("fibers[{bundle}]: {source}")]
    Fiber {
        /// Index of the bundle in the scene.
        bundle: usize,
        /// What is wrong with the fibre.
        source: FiberError,
    },
    /// A rod of the scene cannot be built or restored.
    #[error("fibers[{bundle}]: {source}")]
    Rod {
        /// Index of the bundle in the scene.
        bundle: usize,
        /// What is wrong with the rod.
        source: RodError,
    },
    /// The hair of a bundle is not known in the climate of the scene.
    #[error("fibers[{bundle}]: {source}")]
    Keratin {
        /// Index of the bundle in the scene.
        bundle: usize,
        /// What is not known.
        source: KeratinError,
    },
    /// What the laboratory was asked is not known or not read.
    #[error(transparent)]
    Laboratory(#[from] KeratinError),
    /// A hair of the laboratory has no equilibrium.
    #[error(transparent)]
    Equilibrium(#[from] EquilibriumError),
    /// Fibres cannot start or be moved.
    #[error(transparent)]
    Coupling(#[from] CouplingError),
    /// Fibres with charge do not come to rest.
    #[error(transparent)]
    Charging(#[from] ChargingError),
    /// A stepper of the user's own cannot go on.
    #[error(transparent)]
    Stepper(#[from] Box<dyn std::error::Error + Send + Sync>),
    /// A fibre cannot be put into a state.
    #[error("fibre {fiber}: {source}")]
    State {
        /// Index of the fibre, over all bundles.
        fiber: usize,
        /// What is wrong with the state.
        source: RodError,
    },
    /// A state is given to what is no fibre.
    #[error("a state can only be given to fibres, and only to those that are no charged ones")]
    NoFibers,
    /// A snapshot is one of other objects.
    #[error("the saved state belongs to a world with other free objects")]
    OtherObjects,
    /// A mesh of an object cannot be given a mass.
    #[error("objects[{object}]: {source}")]
    Body {
        /// Index of the object in the scene.
        object: usize,
        /// What is wrong with its mass.
        source: ContactError,
    },
    /// A motion has left all bounds.
    #[error(
        "the run stopped at t = {time} s: its energy is no number any more; set stepper.dt to less, \
         or choose the method BackwardEuler or an implicit integrator"
    )]
    NotFinite {
        /// When it was seen, s.
        time: f64,
    },
    /// A run has more energy than it was given.
    #[error(
        "the run stopped at t = {time} s: {created:.2e} J came from nowhere, beside {supplied:.2e} J \
         that it was given{}; set stepper.dt to less, or choose a method that damps more \
         (BackwardEuler, or Staggered with a rho_infinity of at most 0.4)",
        fiber.map_or_else(String::new, |fiber| format!(", most of it in fibre {fiber}"))
    )]
    Created {
        /// When it was seen, s.
        time: f64,
        /// Energy that no work explains, J.
        created: f64,
        /// Kinetic and elastic energy of the start, and all that gravity, loads, air, supports and
        /// objects have given, J.
        supplied: f64,
        /// The fibre with most energy, counted over all bundles, if there are fibres.
        fiber: Option<usize>,
    },
    /// The file of a closed curve is not understood.
    #[error(
        "fibers[{bundle}], {}{}: {why}", path.display(),
        line.map_or_else(String::new, |line| format!(", line {line}"))
    )]
    Curve {
        /// Index of the bundle in the scene.
        bundle: usize,
        /// The file.
        path: PathBuf,
        /// Line, from 1; none for what concerns the whole.
        line: Option<usize>,
        /// What is wrong.
        why: String,
    },
    /// The mesh of an object is not closed, or not read.
    #[error("objects[{object}], {}: {source}", path.display())]
    Mesh {
        /// Index of the object in the scene.
        object: usize,
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: CollisionError,
    },
    /// An object cannot be built although each of its numbers is in range.
    #[error("objects[{object}]: {source}")]
    Object {
        /// Index of the object in the scene.
        object: usize,
        /// What is wrong with it.
        source: CollisionError,
    },
    /// A rod has no equilibrium that was found.
    #[error("the case has no answer: {0}")]
    Static(#[from] StaticError),
    /// What is asked of a case has no answer.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// A mass-spring system cannot be built, restored or moved.
    #[error("mass_spring, t = {time} s: {source}")]
    MassSpring {
        /// Start of the step, s.
        time: f64,
        /// What is wrong, and where.
        source: SpringError,
    },
    /// A scene would take too much memory.
    #[error(
        "{path}: {what} take some {:.2} GB of memory, and {:.2} GB are allowed; ask for less, or \
         allow more",
        bytes * 1e-9, most * 1e-9
    )]
    Memory {
        /// Path of the field that asks for most.
        path: String,
        /// What it makes.
        what: String,
        /// What all of the scene takes, bytes.
        bytes: f64,
        /// What it may take, bytes.
        most: f64,
    },
    /// Reading or writing failed.
    #[error("cannot {action} {}: {}", path.display(), explained(source))]
    Io {
        /// What was tried, a verb.
        action: &'static str,
        /// Where.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// A frame cannot be written, read back, or drawn.
    #[error("{}: {source}", path.display())]
    Export {
        /// The file.
        path: PathBuf,
        /// Why.
        source: StudioError,
    },
    /// The simulation is at its end, but some of its files could not be written.
    #[error(
        "the simulation is complete, but {} not written; mend the cause and resume the run, which \
         writes them:{}",
        if faults.len() == 1 { "a file was".into() } else { format!("{} files were", faults.len()) },
        first_of(faults)
    )]
    Unwritten {
        /// Why each was not.
        faults: Vec<Self>,
    },
    /// Another run holds the folder.
    #[error(
        "{} is in use by the run with process number {process}; wait for it, stop it, or choose \
         another folder",
        path.display()
    )]
    FolderInUse {
        /// The folder.
        path: PathBuf,
        /// Who holds it, as written in its lock file.
        process: String,
    },
    /// The folder is not that of a run.
    #[error(
        "{} holds no run, or one that was stopped before its first frame: it has no summary.json; \
         check the path",
        .0.display()
    )]
    NoRun(PathBuf),
    /// The folder has contents that would be overwritten.
    #[error("{} is not empty: resume the run in it, or force a new one, or choose another folder", .0.display())]
    FolderNotEmpty(PathBuf),
    /// The run in the folder has results, but nothing to go on from.
    #[error(
        "{} holds a run without a checkpoint: there is nothing to go on from; force a new run, which \
         replaces its files, or choose another folder",
        .0.display()
    )]
    NoCheckpoint(PathBuf),
    /// A file that is not of a run is where one of a run belongs.
    #[error(
        "{} is not a file that a run made, and a run would overwrite it; move it away, or choose \
         another folder",
        .0.display()
    )]
    ForeignFile(PathBuf),
    /// A file that the run reads is where one of its own belongs.
    #[error("{} is read by the run, which would overwrite it; choose another folder", .0.display())]
    OverInput(PathBuf),
    /// A link, or something else that is no plain file or folder, is where one of a run belongs.
    #[error(
        "{} is {}, and a run would have a {} there; remove it, or choose another folder",
        path.display(),
        if *link { "a link, which is not followed" } else { "something else" },
        if *folder { "folder" } else { "file" }
    )]
    NotPlain {
        /// Where.
        path: PathBuf,
        /// Whether it is a link.
        link: bool,
        /// Whether a folder should be there, not a file.
        folder: bool,
    },
    /// The folder holds a run of a different scene.
    #[error(
        "{} holds a run of a different scene (or of one that has changed since); resume with the \
         scene.ron in that folder, or force a new run",
        .0.display()
    )]
    DifferentScene(PathBuf),
    /// A checkpoint cannot be used.
    #[error("the checkpoint {} {why}", path.display())]
    Checkpoint {
        /// The file.
        path: PathBuf,
        /// What is wrong with it and what to do.
        why: String,
    },
}

impl SimError {
    /// An [`SimError::Export`] of a file.
    pub(crate) fn export<E: Into<StudioError>>(path: &Path) -> impl FnOnce(E) -> Self {
        move |source| Self::Export { path: path.to_owned(), source: source.into() }
    }

    /// An [`SimError::Io`] from what was tried on which path.
    pub(crate) fn io<'a>(
        action: &'static str,
        path: &'a (impl AsRef<Path> + ?Sized),
    ) -> impl FnOnce(io::Error) -> Self + 'a {
        move |source| Self::Io { action, path: path.as_ref().to_owned(), source }
    }
}

/// Most faults that a message tells.
const TOLD: usize = 10;

fn first_of(faults: &[SimError]) -> String {
    let told: String = faults.iter().take(TOLD).map(|fault| format!("\n  {fault}")).collect();
    let more = faults.len().saturating_sub(TOLD);
    if more == 0 { told } else { format!("{told}\n  and {more} more") }
}

/// The operating system's words, with what to do where that is known.
fn explained(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            format!("{error}; free some space and resume the run")
        }
        io::ErrorKind::FileTooLarge => {
            format!("{error}; raise the limit on file sizes and resume the run")
        }
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            format!("{error}; choose a folder that you may write to")
        }
        io::ErrorKind::AlreadyExists | io::ErrorKind::NotADirectory => {
            format!("{error}; a file is in its place: choose another folder")
        }
        io::ErrorKind::NotFound => format!("{error}; check the path"),
        _ => error.to_string(),
    }
}
