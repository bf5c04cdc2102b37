use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode};
use rapunzel_sim::scene::{SceneError, SceneProblem};
use rapunzel_sim::statics::CaseError;
use rapunzel_sim::{ChargingError, CouplingError, SimError};
use std::fmt;
use std::path::{Path, PathBuf};

/// Why a command did not do what it was asked to.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The simulation said no.
    Sim {
        error: SimError,
        /// The file of the scene.
        scene: PathBuf,
    },
    /// A file or folder cannot be used.
    File(String),
}

/// The physics does not come out: a step could not be taken, energy came from nowhere, an
/// equilibrium was not found.
const FAILED: u8 = 1;
/// The scene is wrong.
const SCENE: u8 = 3;
/// A file or folder cannot be used.
const FILE: u8 = 4;
/// Interrupted by the user: 128 and the number of the signal, as shells have it.
pub(crate) const INTERRUPTED: u8 = 130;
/// Complete, but contacts or charged fibres missed their tolerances in some steps, or no
/// equilibrium that was found is stable.
pub(crate) const UNRESOLVED: u8 = 5;

impl Failure {
    /// An error of the simulation of the scene in `scene`.
    pub(crate) fn of<E: Into<SimError>>(scene: &Path) -> impl Fn(E) -> Self {
        move |error| Self::Sim { error: error.into(), scene: scene.to_owned() }
    }

    pub(crate) fn code(&self) -> u8 {
        match self {
            Self::Sim {
                error:
                    SimError::NotFinite { .. }
                    | SimError::Created { .. }
                    | SimError::Static(_)
                    | SimError::Equilibrium(_)
                    | SimError::Case(CaseError::NoLength { .. } | CaseError::NotCritical { .. }),
                ..
            } => FAILED,
            // At the start the system is that of the scene.
            Self::Sim { error: SimError::MassSpring { time, .. }, .. } => {
                if *time > 0.0 {
                    FAILED
                } else {
                    SCENE
                }
            }
            Self::Sim {
                error:
                    SimError::Scene(_)
                    | SimError::Hairstyle(_)
                    | SimError::Fiber { .. }
                    | SimError::Keratin { .. }
                    | SimError::Laboratory(_)
                    | SimError::Memory { .. }
                    | SimError::Rod { .. }
                    | SimError::Case(_)
                    | SimError::Object { .. }
                    | SimError::Body { .. }
                    | SimError::Coupling(CouplingError::Overlap { .. })
                    | SimError::Charging(ChargingError::Keratin { .. } | ChargingError::Head { .. }),
                ..
            } => SCENE,
            Self::Sim {
                error:
                    SimError::Coupling(CouplingError::Restore(_))
                    | SimError::Charging(ChargingError::Saved { .. }),
                ..
            } => FILE,
            Self::Sim { error: SimError::Coupling(_) | SimError::Charging(_), .. } => FAILED,
            Self::Sim { .. } | Self::File(_) => FILE,
        }
    }

    /// What is wrong with the scene, if that is what is.
    pub(crate) fn problems(&self) -> &[SceneProblem] {
        match self {
            Self::Sim { error: SimError::Scene(SceneError { problems, .. }), .. } => problems,
            _ => &[],
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sim { error: error @ SimError::Scene(_), scene } => {
                write!(f, "{}: {error}", scene.display())
            }
            Self::Sim { error, .. } => error.fmt(f),
            Self::File(message) => message.fmt(f),
        }
    }
}

pub(crate) fn as_json(problem: &SceneProblem) -> serde_json::Value {
    serde_json::json!({
        "path": problem.path, "message": problem.message,
        "line": problem.place.as_ref().map(|place| place.line),
        "column": problem.place.as_ref().map(|place| place.column),
    })
}

/// A problem of a scene, underlined in its text.
#[derive(Debug)]
pub(crate) struct SceneReport {
    pub(crate) source: NamedSource<String>,
    pub(crate) problem: SceneProblem,
}

impl fmt::Display for SceneReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SceneProblem { path, message, .. } = &self.problem;
        if path.is_empty() { message.fmt(f) } else { write!(f, "{path}: {message}") }
    }
}

impl std::error::Error for SceneReport {}

impl Diagnostic for SceneReport {
    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(&self.source)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let place = self.problem.place.as_ref()?;
        Some(Box::new(std::iter::once(LabeledSpan::underline(place.span.clone()))))
    }
}
