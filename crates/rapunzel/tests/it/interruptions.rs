//! Runs that are interrupted or killed at any moment, and go on.

use crate::common::{SCENE, rapunzel, run_in, scene_file, wait_for};
use rapunzel_export::vtp;
use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::Duration;

/// Long enough to be hit in the middle, with hairs whose tips rub over the ground.
fn long_scene() -> String {
    let ground = "objects: [(shape: Plane(normal: (0, 0, 1)), position: (0.0, 0.0, -0.0271))],
        contact: (friction: Isotropic(0.3)), stepper";
    let [few, many] = [
        "Lock(count: 2, radius: 0.003, curvature_variation: 0.1)",
        "Ellipse(semi_axes: (0.003, 0.003), count: 12)",
    ];
    let long = SCENE.replace("duration: 0.5", "duration: 1").replace(few, many);
    long.replace("stepper", ground)
}

/// The finished frames of a run, each of them whole.
fn frames(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let files = fs::read_dir(folder.join("frames")).into_iter().flatten().flatten();
    let is_frame = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str());
        name.is_some_and(|name| name.starts_with("frame-") && name.ends_with(".vtp"))
    };
    let paths = files.map(|file| file.path()).filter(is_frame);
    let whole = paths.map(|path| {
        let bytes = fs::read(&path).expect("readable");
        vtp::read(&mut &bytes[..]).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        (path, bytes)
    });
    whole.collect()
}

/// All files of a run but its log, which tells of interruptions, and its lock.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let frames = fs::read_dir(folder.join("frames")).expect("frames");
    let files = fs::read_dir(folder).expect("a folder").chain(frames).flatten();
    let files = files.map(|file| file.path()).filter(|path| path.is_file());
    let named = files.map(|path| {
        let name = path.strip_prefix(folder).expect("inside").display().to_string();
        (name, fs::read(&path).expect("readable"))
    });
    named.filter(|(name, _)| name != "run.log" && name != ".lock").collect()
}

fn assert_same(a: &Path, b: &Path) {
    let (a, b) = (files(a), files(b));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (name, bytes) in &a {
        assert!(bytes == &b[name], "{name} differs");
    }
}

fn start(scene: &Path, out: &Path, threads: &str) -> Child {
    let mut command = run_in(scene, out);
    command.args(["--resume", "--sync-every", "0.02", "--threads", threads]);
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("starts")
}

#[test]
fn a_killed_run_goes_on_to_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_file(folder.path(), &long_scene());
    let (whole, parts) = (folder.path().join("whole"), folder.path().join("parts"));
    assert!(run_in(&scene, &whole).status().expect("runs").success());
    // Delays without a common measure, so that the kills fall anywhere: the first ones before
    // there is a checkpoint.
    let (mut kills, mut finished) = (0, frames(&parts));
    for i in 0..12 {
        let mut child = start(&scene, &parts, if i % 2 == 0 { "1" } else { "3" });
        std::thread::sleep(Duration::from_millis(3 + 17 * i));
        child.kill().expect("a child");
        kills += u32::from(!child.wait().expect("ends").success());
        let now = frames(&parts);
        for (path, bytes) in finished {
            assert!(now.get(&path) == Some(&bytes), "{} is lost or changed", path.display());
        }
        finished = now;
    }
    let info = rapunzel().args(["info", "--json"]).arg(&whole).output().expect("runs");
    let info: serde_json::Value = serde_json::from_slice(&info.stdout).expect("JSON");
    assert!(info["summary"]["contact"]["active"].as_u64() > Some(10), "{info}");
    assert!(kills >= 6, "only {kills} of 12 runs were killed before their end");
    assert!(start(&scene, &parts, "2").wait().expect("ends").success());
    assert_same(&whole, &parts);
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_a_checkpoint_and_its_own_code() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_file(folder.path(), &long_scene());
    let (whole, parts) = (folder.path().join("whole"), folder.path().join("parts"));
    let mut child = start(&scene, &parts, "1");
    wait_for(&parts.join("frames/frame-000001.vtp"));
    let pid = child.id().to_string();
    std::process::Command::new("kill").args(["-INT", &pid]).status().expect("sends a signal");
    assert_eq!(child.wait().expect("ends").code(), Some(130));
    let info = rapunzel().args(["info", "--json"]).arg(&parts).output().expect("runs");
    let info: serde_json::Value = serde_json::from_slice(&info.stdout).expect("JSON");
    assert_eq!(info["summary"]["outcome"], "cancelled", "{info}");
    assert!(start(&scene, &parts, "1").wait().expect("ends").success());
    assert!(run_in(&scene, &whole).status().expect("runs").success());
    assert_same(&whole, &parts);
}

#[cfg(unix)]
#[test]
fn an_interrupted_page_keeps_where_the_scene_stood() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_file(folder.path(), SCENE);
    let mut command = rapunzel();
    command.args(["view", "--json", "--run", "--no-browser"]).arg(&scene);
    let mut child = command.stdout(Stdio::piped()).spawn().expect("starts");
    let mut lines = BufReader::new(child.stdout.take().expect("piped")).lines();
    let first = lines.next().expect("a line").expect("text");
    assert!(first.contains("http://127.0.0.1:"), "{first}");
    // Long enough for the first of two thousand steps a second.
    std::thread::sleep(Duration::from_secs(1));
    let pid = child.id().to_string();
    std::process::Command::new("kill").args(["-INT", &pid]).status().expect("sends a signal");
    assert_eq!(child.wait().expect("ends").code(), Some(130));
    let told = lines.next().expect("a line").expect("text");
    let told: serde_json::Value = serde_json::from_str(&told).expect("JSON");
    let kept = Path::new(told["kept"].as_str().expect("a path"));
    assert!(kept.is_file() && kept.with_extension("checkpoint").is_file(), "{told}");
    let check = rapunzel().arg("check").arg(kept).output().expect("runs");
    assert!(check.status.success(), "{check:?}");
}

#[test]
fn a_shipped_scene_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/sine-under-gravity.ron");
    let out = folder.path().join("out");
    assert!(run_in(&scene, &out).status().expect("runs").success());
    assert!(out.join("summary.json").exists());
}

#[test]
fn a_run_says_what_it_did_to_machines() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_file(folder.path(), SCENE);
    let out = folder.path().join("out");
    let output = run_in(&scene, &out).arg("--json").output().expect("runs");
    let object: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(object["summary"]["outcome"], "complete", "{object}");
    assert_eq!(object["summary"]["frames"], 16, "{object}");
    assert_eq!(object["folder"], out.display().to_string(), "{object}");
}
