//! The scenes of the gallery, with their pictures.

use rapunzel_export::Frame;
use rapunzel_scene::style_from_ron;
use rapunzel_sim::{Scene, World};
use rapunzel_studio::sheet::{self, PreviewFrame};
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Cursor};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use tempfile::TempDir;

/// Width and height of a picture at most, pixels: twice those of its card, for fine screens.
const PICTURE: [u16; 2] = [480, 360];

/// A scene of the gallery.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GalleryScene {
    /// Its name: letters, digits, `-` and `/`.
    pub name: String,
    /// Its text.
    pub text: String,
    /// Names and texts of the files that it names, which lie beside it.
    pub files: Vec<(String, String)>,
}

impl GalleryScene {
    /// The scene, if it is shown live.
    pub(crate) fn scene(&self) -> Option<Scene> {
        Scene::from_ron(&self.text).ok().filter(|scene| self.lacks(scene).is_none())
    }

    /// What keeps a scene out of the gallery.
    fn lacks(&self, scene: &Scene) -> Option<Omission> {
        if scene.styles().next().is_some() {
            return Some(Omission::Grows);
        }
        (!self.has_files(scene)).then_some(Omission::NeedsFiles)
    }

    fn has_files(&self, scene: &Scene) -> bool {
        // A name that leads elsewhere is of no file beside it.
        let is_beside = |name: &Path| name.file_name() == Some(name.as_os_str());
        scene.files().all(|file| {
            is_beside(file) && self.files.iter().any(|(name, _)| Path::new(name) == file)
        })
    }

    /// Puts the files that it names into a folder.
    pub(crate) fn lay_out(&self) -> io::Result<Option<TempDir>> {
        if self.files.is_empty() {
            return Ok(None);
        }
        let folder = tempfile::Builder::new().prefix("rapunzel-").tempdir()?;
        for (name, text) in &self.files {
            let plain = Path::new(name).file_name().unwrap_or_default();
            fs::write(folder.path().join(plain), text)?;
        }
        Ok(Some(folder))
    }

    /// Why it is not shown live in the gallery, if it is not.
    pub(crate) fn left_out(&self) -> Option<Omission> {
        match Scene::from_ron(&self.text) {
            Ok(scene) => self.lacks(&scene),
            Err(_) if style_from_ron(&self.text).is_ok() => Some(Omission::IsStyle),
            Err(_) => Some(Omission::IsCase),
        }
    }
}

/// Why something that ships is not shown live in the gallery.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Omission {
    /// A scene that names files which are not there.
    NeedsFiles,
    /// A scene whose hair grows from a style first and settles, for seconds to minutes: a card
    /// opens at once, and its picture must not keep the others waiting.
    Grows,
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
            Self::Grows => "grows",
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
        let picture: Arc<[u8]> = draw(scene)?.into();
        drawn.insert(name.to_owned(), Arc::clone(&picture));
        Some(picture)
    }
}

fn draw(item: &GalleryScene) -> Option<Vec<u8>> {
    let (scene, folder) = (item.scene()?, item.lay_out().ok()?);
    let scene = match &folder {
        Some(folder) => scene.seen_from(folder.path()),
        None => scene,
    };
    let world = World::build(&scene).ok()?;
    let strands = world.stepper().strands().collect();
    let frame = Frame { index: 0, time: 0.0, strands };
    let supports = world.stepper().scenery().supports;
    let supports = supports.into_iter().filter(|(_, times)| times.contains(&0.0));
    let preview = PreviewFrame::new(frame, supports.map(|(support, _)| support).collect()).ok()?;
    let mut png = Cursor::new(Vec::new());
    let objects: Vec<_> = world.surfaces().collect();
    sheet::write_small(&mut png, &preview, &objects, PICTURE).ok()?;
    Some(png.into_inner())
}
