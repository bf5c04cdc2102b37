//! The scenes of the gallery, with their pictures.

use rapunzel_export::Frame;
use rapunzel_scene::style_from_ron;
use rapunzel_sim::{Scene, World};
use rapunzel_studio::sheet::{self, PreviewFrame};
use std::collections::BTreeMap;
use std::io::Cursor;
use std::sync::{Arc, Mutex, PoisonError};

/// A scene of the gallery.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GalleryScene {
    /// Its name: letters, digits, `-` and `/`.
    pub name: String,
    /// Its text.
    pub text: String,
}

impl GalleryScene {
    /// The scene, if it stands alone: without files, as they would have no folder.
    pub(crate) fn scene(&self) -> Option<Scene> {
        Scene::from_ron(&self.text).ok().filter(|scene| scene.files().next().is_none())
    }

    /// Why it is not shown live in the gallery, if it is not.
    pub(crate) fn left_out(&self) -> Option<Omission> {
        match Scene::from_ron(&self.text) {
            Ok(scene) => scene.files().next().map(|_| Omission::NeedsFiles),
            Err(_) if style_from_ron(&self.text).is_ok() => Some(Omission::IsStyle),
            Err(_) => Some(Omission::IsCase),
        }
    }
}

/// Why something that ships is not shown live in the gallery.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Omission {
    /// A scene that names files, for which it has no folder.
    NeedsFiles,
    /// A style, which grows for a while.
    IsStyle,
    /// A case, which is solved and does not run.
    IsCase,
}

impl Omission {
    /// Its name, by which pages know it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::NeedsFiles => "needs_files",
            Self::IsStyle => "is_style",
            Self::IsCase => "is_case",
        }
    }
}

/// Pictures of the scenes at their start, each drawn when it is first asked for.
#[derive(Debug)]
pub(crate) struct GalleryPictures {
    scenes: Vec<GalleryScene>,
    drawn: Mutex<BTreeMap<String, Arc<[u8]>>>,
}

impl GalleryPictures {
    pub(crate) fn new(scenes: Vec<GalleryScene>) -> Self {
        Self { scenes, drawn: Mutex::default() }
    }

    /// The picture of a scene, as PNG; none if there is no such scene or it cannot be drawn.
    ///
    /// One is drawn at a time: the simulation needs the machine too.
    pub(crate) fn get(&self, name: &str) -> Option<Arc<[u8]>> {
        let scene = self.scenes.iter().find(|scene| scene.name == name)?;
        let mut drawn = self.drawn.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(picture) = drawn.get(name) {
            return Some(Arc::clone(picture));
        }
        let picture: Arc<[u8]> = draw(&scene.scene()?)?.into();
        drawn.insert(name.to_owned(), Arc::clone(&picture));
        Some(picture)
    }
}

fn draw(scene: &Scene) -> Option<Vec<u8>> {
    let world = World::build(scene).ok()?;
    let strands = world.stepper().strands().collect();
    let frame = Frame { index: 0, time: 0.0, strands };
    let supports = world.stepper().scenery().supports;
    let supports = supports.into_iter().filter(|(_, times)| times.contains(&0.0));
    let preview = PreviewFrame::new(frame, supports.map(|(support, _)| support).collect()).ok()?;
    let mut png = Cursor::new(Vec::new());
    sheet::write(&mut png, &[preview], &[world.surfaces().collect()], &[]).ok()?;
    Some(png.into_inner())
}
