//! What is shown.

use crate::GalleryScene;
use crate::extras::Shows;
use crate::frame::Colors;
use crate::live::{KEPT, Live};
use crate::recorded::Recorded;
use rapunzel_export::Frame;
use rapunzel_export::surface::Placed;
use rapunzel_scene::style_from_ron;
use rapunzel_sim::scene::SceneProblem;
use rapunzel_sim::{BuildStage, Scene, ShownStage, SimError, read_text};
use std::path::Path;

/// What is shown.
pub(crate) enum Showing {
    /// The gallery, and nothing else yet.
    Gallery,
    Live(Box<Live>),
    Recorded(Box<Recorded>),
    /// What cannot be shown, and why.
    Broken(Broken),
}

/// Why something cannot be shown.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Broken {
    pub(crate) message: String,
    /// What is wrong with a scene.
    pub(crate) problems: Vec<SceneProblem>,
}

impl Showing {
    /// Opens a scene, a run, with another `beside` it if there is one, a style or strands; parts of
    /// long work are told to `at`.
    pub(crate) fn open(path: &Path, beside: Option<&Path>, at: &dyn Fn(ShownStage)) -> Self {
        let opened = if is_text(path) && beside.is_none() {
            open_text(path, at)
        } else {
            open_recorded(path, beside, at)
        };
        opened.unwrap_or_else(|error| Self::Broken(Broken::of(&error)))
    }

    /// Builds a scene of the gallery; one that names no files is seen from `folder`.
    pub(crate) fn build(
        item: &GalleryScene,
        scene: Scene,
        folder: &Path,
        at: &dyn Fn(BuildStage),
    ) -> Self {
        match Live::of_gallery(item, scene, folder, at) {
            Ok(live) => Self::Live(Box::new(live)),
            Err(error) => Self::Broken(Broken::of(&error)),
        }
    }

    /// Whether a hand holds something.
    pub(crate) fn is_held(&self) -> bool {
        matches!(self, Self::Live(live) if live.hand.is_some() || live.drag.is_some())
    }

    /// A new layout; none where nothing is shown.
    pub(crate) fn layout(&self, number: u32) -> Option<Vec<u8>> {
        match self {
            Self::Live(live) => Some(live.layout(number)),
            Self::Recorded(recorded) => Some(recorded.layout(number)),
            Self::Gallery | Self::Broken(_) => None,
        }
    }

    pub(crate) fn frame(
        &mut self,
        layout: u32,
        colors: &mut Colors,
        shows: Shows,
    ) -> Option<Vec<u8>> {
        match self {
            Self::Live(live) => Some(live.frame(layout, colors, shows)),
            Self::Recorded(recorded) => Some(recorded.frame(layout, colors, shows)),
            Self::Gallery | Self::Broken(_) => None,
        }
    }

    /// Strands and objects as a picture shows them, and the ratio of the semi-axes of sections.
    pub(crate) fn picture(&self) -> Option<(Frame, Vec<Placed>, Option<f64>)> {
        match self {
            Self::Live(live) => Some(live.picture()),
            Self::Recorded(recorded) => Some(recorded.picture()),
            Self::Gallery | Self::Broken(_) => None,
        }
    }
}

impl Broken {
    pub(crate) fn of(error: &SimError) -> Self {
        let problems = match error {
            SimError::Scene(error) => error.problems.clone(),
            _ => Vec::new(),
        };
        Self { message: error.to_string(), problems }
    }
}

fn is_text(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("ron")) && !path.is_dir()
}

/// A scene runs, from where it was left if that was kept beside it; a style is shown as it has
/// grown.
fn open_text(path: &Path, at: &dyn Fn(ShownStage)) -> Result<Showing, SimError> {
    let text = read_text(path)?;
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let folder = whole.parent().unwrap_or(Path::new("."));
    match Scene::from_ron(&text) {
        Ok(scene) => {
            let mut live = Live::new(scene, folder, &|stage| at(ShownStage::Building(stage)))?;
            live.take_up(&whole.with_extension(KEPT));
            Ok(Showing::Live(Box::new(live)))
        }
        Err(_) if style_from_ron(&text).is_ok() => open_recorded(path, None, at),
        Err(error) => Err(error.into()),
    }
}

fn open_recorded(
    path: &Path,
    beside: Option<&Path>,
    at: &dyn Fn(ShownStage),
) -> Result<Showing, SimError> {
    Ok(Showing::Recorded(Box::new(Recorded::open(path, beside, at)?)))
}
