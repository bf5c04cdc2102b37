//! The scenes and cases that ship, inside the program.

use rapunzel_sim::Scene;
use std::path::Path;

macro_rules! templates {
    ($($name:literal),+ $(,)?) => {
        /// Names of the scenes.
        pub(crate) const NAMES: &[&str] = &[$($name),+];
        /// Texts of the scenes, in the order of the names.
        const TEXTS: &[&str] = &[$(include_str!(concat!("../../../scenes/", $name, ".ron"))),+];
    };
}

templates![
    "lock-under-gravity",
    "sine-under-gravity",
    "helix-with-end-load",
    "straight-rod-with-torque",
    "prestressed-spring",
    "buckling",
    "lock-pulled",
    "lock-falling",
    "lock-on-moving-root",
    "water-wave",
    "fishing-rod",
    "twisting-machine",
    "joined/twisted-ring",
    "joined/net",
    "joined/braid",
    "joined/mobile",
    "joined/chain",
    "contact/lock-on-ball",
    "contact/bundle-on-slope",
    "contact/bundle-on-terrain",
    "contact/helical-bundle-on-ball",
    "contact/horizontal-bundle-on-ball",
    "contact/partly-elastic",
    "contact/partly-elastic-limp",
    "contact/friction-none",
    "contact/friction-isotropic",
    "contact/friction-anisotropic",
    "contact/comb",
    "contact/knot",
    "contact/figure-eight",
    "contact/head",
    "contact/turned-head",
    "contact/wrapped",
    "contact/coiling",
    "contact/plectoneme",
    "charge/tress",
    "charge/tress-without-gravity",
    "charge/van-de-graaff",
    "charge/half-head",
    "mass-spring/rope",
    "mass-spring/rope-in-wind",
    "mass-spring/chain",
    "mass-spring/cloth-on-a-line",
    "mass-spring/flag",
    "mass-spring/net-beyond-its-limit",
    "mass-spring/thin-beam",
    "mass-spring/beam-buckling",
    "mass-spring/cube",
    "mass-spring/cube-under-lid",
    "mass-spring/thick-beam",
    "mass-spring/ring",
    "mass-spring/ball",
    "static/hose-between-flanges",
    "static/tress-root",
    "static/follower-load",
    "static/upright-rod",
    "static/two-places",
    "static/fishing-rod",
    "static/column",
    "static/snapping-arch",
    "static/twisted-ring",
    "static/joined-rods",
    "static/laid-on-a-bar",
    "style/bob",
    "style/long",
    "style/afro",
    "style/wavy",
    "style/curly",
    "style/standing",
    "style/tress",
    "style/shaken-head",
];

/// What else scenes that ship name, by the path among them.
const FILES: &[(&str, &str)] =
    &[("charge/head.obj", include_str!("../../../scenes/charge/head.obj"))];

/// Something that ships, as it can lie in a folder with the files that it names.
pub(crate) struct Template {
    /// Its text, with plain names of these files.
    pub(crate) text: String,
    /// Their names, each once, and texts.
    pub(crate) files: Vec<(String, &'static str)>,
}

/// What ships by a name.
pub(crate) fn template(name: &str) -> Option<Template> {
    let mut text = text(name)?.to_owned();
    // It is copied into any folder, not into a folder of its own.
    let folder = name.rsplit_once('/').map_or("", |(folder, _)| folder);
    let scene = Scene::from_ron(&text).ok();
    let mut files: Vec<(String, &str)> = Vec::new();
    for file in scene.iter().flat_map(Scene::files) {
        let (Some(old), Some(new)) = (file.to_str(), file.file_name()) else { continue };
        let new = new.to_string_lossy().into_owned();
        // What it names lies beside it, wherever it lies among the scenes that ship.
        text = text.replace(&format!("\"{old}\""), &format!("\"{new}\""));
        if let Some(content) = shipped(&path_of(folder, file))
            && !files.iter().any(|(known, _)| *known == new)
        {
            files.push((new, content));
        }
    }
    Some(Template { text, files })
}

/// The path among what ships of a file that a scene in one of its folders names.
fn path_of(folder: &str, file: &Path) -> String {
    let mut parts: Vec<String> = folder.split('/').map(str::to_owned).collect();
    for part in file {
        if part == ".." {
            parts.pop();
        } else {
            parts.push(part.to_string_lossy().into_owned());
        }
    }
    parts.join("/")
}

/// The text of a file that ships.
fn shipped(path: &str) -> Option<&'static str> {
    let other = || FILES.iter().find(|(own, _)| *own == path).map(|(_, text)| *text);
    path.strip_suffix(".ron").and_then(text).or_else(other)
}

fn text(name: &str) -> Option<&'static str> {
    NAMES.iter().position(|n| *n == name).map(|i| TEXTS[i])
}
