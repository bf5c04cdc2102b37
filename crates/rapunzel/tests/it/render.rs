//! Pictures from the command line.

use crate::common::rapunzel;
use std::fs;
use std::path::Path;
use std::process::Output;

/// A fibre that swings: three frames.
const SCENE: &str = "(format: 1, duration: 0.02,
    fibers: [(length: 0.1, segments: 8, section: Circle(radius: 1e-3), damping_time: 1e-3)],
    stepper: (dt: 5e-3), output: (frame_rate: 100.0))";

fn render(folder: &Path, arguments: &[&str]) -> Output {
    let small = ["--size", "48x36", "--samples", "4"];
    rapunzel().current_dir(folder).arg("render").args(arguments).args(small).output().expect("runs")
}

fn picture(folder: &Path, arguments: &[&str]) -> Vec<u8> {
    let output = render(folder, arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    fs::read(folder.join("out.png")).expect("a picture")
}

fn scene() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("scene.ron"), SCENE).expect("written");
    folder
}

#[test]
fn a_scene_is_the_same_picture_on_any_number_of_threads() {
    let folder = scene();
    let of = |threads: &str| {
        picture(folder.path(), &["scene.ron", "--out", "out.png", "--exr", "--threads", threads])
    };
    let one = of("1");
    assert!(one.starts_with(b"\x89PNG"));
    assert_eq!(of("2"), one);
    assert!(fs::metadata(folder.path().join("out.exr")).is_ok_and(|file| file.len() > 1000));
    let colored = picture(
        folder.path(),
        &["scene.ron", "--out", "out.png", "--color-by", "curvature", "--camera", "front"],
    );
    assert_ne!(colored, one);
}

#[test]
fn a_run_is_a_film() {
    let folder = scene();
    let run = rapunzel().current_dir(folder.path()).args(["run", "scene.ron"]).output();
    let run = run.expect("runs");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let film = render(folder.path(), &["runs/scene", "--film", "--out", "film", "--json"]);
    assert!(film.status.success(), "{}", String::from_utf8_lossy(&film.stderr));
    for number in 0..3 {
        assert!(folder.path().join(format!("film/picture-{number:04}.png")).is_file(), "{number}");
    }
    let told = String::from_utf8_lossy(&film.stdout).into_owned();
    let told: serde_json::Value = serde_json::from_str(&told).expect("JSON");
    let pictures = told["pictures"].as_array().expect("a list");
    assert_eq!(pictures.len(), 3);
    assert!(pictures[0]["mean_radiance"][0].as_f64().is_some_and(|mean| mean > 0.0), "{told}");
    assert_eq!(pictures[0]["rejected"], 0);
}

#[test]
fn what_cannot_be_drawn_is_refused_with_a_reason() {
    let folder = scene();
    fs::write(folder.path().join("sky.exr"), "no map").expect("written");
    fs::create_dir(folder.path().join("empty")).expect("a folder");
    for (arguments, code, reason) in [
        (&["scene.ron", "--size", "100000x100000"][..], 2, "cannot be used multiple times"),
        (&["scene.ron", "--frame", "7"], 4, "no frame 7"),
        (&["scene.ron", "--sky", "sky.exr"], 4, "no map of the sky"),
        (&["scene.ron", "--shutter", "nan"], 4, "exposure"),
        (&["scene.ron", "--camera", "0,0,0:0,0,0"], 4, "what the camera looks at"),
        (&["nowhere.usda"], 4, "nowhere.usda"),
        (&["empty"], 4, "nothing to draw"),
        (&["scene.ron", "--camera", "sideways"], 2, "no place of a camera"),
    ] {
        let output = render(folder.path(), arguments);
        let told = String::from_utf8_lossy(&output.stderr).replace('\n', " ");
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {told}");
        let words: Vec<_> = told.split_whitespace().collect();
        assert!(words.join(" ").contains(reason), "{arguments:?}: {told}");
    }
    let output = rapunzel()
        .current_dir(folder.path())
        .args(["render", "scene.ron", "--size", "100000x100000"])
        .output()
        .expect("runs");
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(4), "{told}");
    assert!(told.contains("2^28"), "{told}");
    assert!(!folder.path().join("runs/scene.png").exists());
    assert!(render(folder.path(), &["scene.ron"]).status.success());
    assert!(folder.path().join("runs/scene.png").is_file());
}
