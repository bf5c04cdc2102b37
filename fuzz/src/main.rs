//! Every reader of a user's files, fed by libFuzzer. The environment variable `FUZZ` names the one.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rapunzel_collision::field::{Mesh, Soup, shapes};
use rapunzel_hairgen::growth::GreyImage;
use rapunzel_sim::scene::style_from_ron;
use rapunzel_sim::statics::Case;
use rapunzel_sim::{
    Cancel, Control, Existing, MemoryEstimate, RunFolder, Scene, SimError, World, run,
};
use rapunzel_strands::{ReadOptions, ScalpMesh, StrandFile};
use std::fs;
use std::sync::{LazyLock, Mutex};
use tempfile::TempDir;

/// What a scene may take of memory, bytes: so little that building it takes no time.
const MEMORY: f64 = 5e7;

static TARGET: LazyLock<String> = LazyLock::new(|| std::env::var("FUZZ").unwrap_or_default());
static FOLDER: LazyLock<Mutex<TempDir>> =
    LazyLock::new(|| Mutex::new(tempfile::tempdir().expect("a folder for files")));

fuzz_target!(|data: &[u8]| {
    match TARGET.as_str() {
        "scene" => {
            let _ = scene(&String::from_utf8_lossy(data));
        }
        "case" => {
            let _ = Case::from_ron(&String::from_utf8_lossy(data));
        }
        "ply" => mesh(Soup::read_ply(data).ok()),
        "stl" => mesh(Soup::read_stl(data).ok()),
        "obj" => mesh(Soup::read_obj(data).ok()),
        "curve" => {
            let _ = curve(data);
        }
        "strands" => strands(data),
        "style" => {
            let _ = style_from_ron(&String::from_utf8_lossy(data)).map(|style| style.check());
        }
        "image" => image(data),
        "checkpoint" => {
            let _ = checkpoint(data);
        }
        other => panic!("FUZZ={other} names no reader"),
    }
});

/// What `rapunzel check` does.
fn scene(text: &str) -> Result<(), SimError> {
    let scene = Scene::from_ron(text)?;
    assert_eq!(Scene::from_ron(&scene.to_ron()?)?, scene, "it reads back as the same");
    MemoryEstimate::new(&scene)?.within(MEMORY)?;
    World::build(&scene).map(|_| ())
}

fn mesh(soup: Option<Soup>) {
    let Some(soup) = soup else { return };
    let _ = Mesh::new(soup.clone());
    let _ = Mesh::repaired(soup);
}

/// Strands of a format that the bytes tell, resampled and put on a scalp.
fn strands(data: &[u8]) {
    let Ok(StrandFile { mut strands, report }) =
        StrandFile::read(data, None, &ReadOptions::default())
    else {
        return;
    };
    let _ = report.to_string();
    let _ = strands.resampled(10);
    let scalp = ScalpMesh::new(&shapes::sphere(0.1, 4)).expect("a surface");
    let _ = strands.snap(&scalp, f64::INFINITY);
}

/// A grey image, looked up between its pixels and beyond them.
fn image(data: &[u8]) {
    let Ok(image) = GreyImage::from_png(data) else { return };
    for place in [[0.0, 0.0], [0.3, -0.7], [9.0, -9.0], [f64::NAN, f64::INFINITY]] {
        let value = image.value(&place.into());
        assert!((0.0..=1.0).contains(&value), "{value} at {place:?}");
    }
}

/// A fibre along the curve in a file.
fn curve(data: &[u8]) -> Result<(), SimError> {
    let folder = FOLDER.lock().expect("one thread");
    let path = folder.path().join("curve.obj");
    fs::write(&path, data).expect("written");
    let text = "(format: 1, duration: 1, stepper: (dt: 1e-3), fibers: [(length: 1, segments: 400,
        section: Circle(radius: 4e-5), initial: Knot(curve: File(\"curve.obj\"), scale: 2e-3,
        spacing: 3e-4))])";
    World::build(&Scene::from_ron(text)?.seen_from(folder.path())).map(|_| ())
}

/// A run that goes on from a checkpoint of these bytes, with the hash that they have.
fn checkpoint(data: &[u8]) -> Result<(), SimError> {
    let folder = FOLDER.lock().expect("one thread");
    let path = folder.path().join("run");
    let scene = Scene::from_ron(include_str!("../seeds/scene.ron"))?;
    let _ = fs::remove_dir_all(&path);
    let mut run_folder = RunFolder::open(&path, Existing::Refuse)?;
    let head = b"RAPUNZEL\x08\0\0\0";
    let file = [&head[..], blake3::hash(data).as_bytes(), data].concat();
    fs::write(path.join("checkpoint.bin"), file).expect("written");
    let cancel = Cancel::new();
    cancel.ask();
    let control = Control {
        sync_is_due: &mut || false,
        cancel: &cancel,
        progress: &mut |_| {},
        stopwatch: None,
    };
    run(&scene, World::build(&scene)?, &mut run_folder, control).map(|_| ())
}
