//! What the program does when something is wrong: exit codes and words.

use crate::common::{SCENE, rapunzel, run_in, scene_file, wait_for};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Output, Stdio};

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// What `rapunzel info` says of a run.
fn info(folder: &Path) -> String {
    let output = rapunzel().arg("info").arg(folder).output().expect("runs");
    assert!(output.status.success(), "{}", stderr(&output));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn a_missing_scene_is_named() {
    let output = rapunzel().args(["run", "no-such.ron"]).output().expect("runs");
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    assert!(stderr(&output).contains("cannot read no-such.ron"), "{}", stderr(&output));
}

#[test]
fn a_wrong_scene_is_underlined() {
    let folder = tempfile::tempdir().expect("a folder");
    for (from, to, message) in [
        ("duration: 0.5", "duration: 0.5 0.6", "Expected comma"),
        ("length: 0.05", "length: -0.05", "fibers[0].length: is -0.05, but must be between"),
        ("segments: 8", "segments: 0", "fibers[0].segments: is 0, but must be between 2"),
        ("length: 0.05", "length: NaN", "fibers[0].length: is NaN"),
        ("dt: 0.001", "dt: 0", "stepper.dt: is 0.0"),
        ("radius: 4e-5", "radius: 0", "fibers[0].section.radius: is 0.0, but must be between"),
        (
            "Swing(angle: 30, radius: 0.05, period: 0.2)",
            "Keyframes(points: [(time: 0), (time: 0, translation: (1, 0, 0))])",
            "fibers[0].motion.points[1].time: is 0.0, but must be later than 0.0",
        ),
    ] {
        let scene = scene_file(folder.path(), &SCENE.replace(from, to));
        for command in ["check", "run"] {
            let output = rapunzel().arg(command).arg(&scene).output().expect("runs");
            let words = stderr(&output).replace("\n  │ ", " ");
            assert_eq!(output.status.code(), Some(3), "{words}");
            assert!(words.contains(message), "{words}");
            assert!(words.contains("scene.ron:"), "the file, line and column: {words}");
        }
    }
    assert!(!folder.path().join("runs").exists(), "nothing was begun");
}

#[test]
fn problems_can_be_read_by_machines() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_file(folder.path(), &SCENE.replace("8,", "0,"));
    let output = rapunzel().args(["check", "--json"]).arg(&scene).output().expect("runs");
    assert_eq!(output.status.code(), Some(3));
    let object: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(object["exit_code"], 3);
    assert_eq!(object["problems"][0]["path"], "fibers[0].segments");
    assert_eq!(object["problems"][0]["line"], 4);
}

/// A ball is driven into a clamped root, which cannot give way: the run goes on, keeps its frames
/// and says so.
#[test]
fn contacts_that_miss_their_tolerances_have_a_code_of_their_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_file(
        folder.path(),
        "(format: 1, duration: 0.002, fibers: [(length: 0.03, segments: 10,
        section: Circle(radius: 3.5e-5), root: (orientation: Along(direction: (0, 0, 1))))],
        objects: [(shape: Ball(radius: 0.01), position: (0.0, 0.0, -0.0101),
        motion: Translate(velocity: (0, 0, 0.5), until: 1))],
        contact: (friction: Isotropic(0.3), iterations: 20),
        environment: (gravity: (0, 0, 0)), stepper: (dt: 1e-3), output: (frame_rate: 1000))",
    );
    let out = folder.path().join("out");
    let output = run_in(&scene, &out).output().expect("runs");
    assert_eq!(output.status.code(), Some(5), "{}", stderr(&output));
    for told in [String::from_utf8_lossy(&output.stdout).into_owned(), info(&out)] {
        assert!(told.contains("parts of steps missed the tolerances of `contact`"), "{told}");
        assert!(told.contains(" s: fibre 0, segment 0, "), "{told}");
    }
    assert!(out.join("frames/frame-000002.vtp").exists());
}

#[test]
fn a_folder_in_use_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_file(folder.path(), &SCENE.replace("duration: 0.5", "duration: 1e4"));
    let out = folder.path().join("out");
    let mut first = run_in(&scene, &out).stderr(Stdio::null()).spawn().expect("starts");
    wait_for(&out.join("summary.json"));
    for option in ["--resume", "--force"] {
        let output = run_in(&scene, &out).arg(option).output().expect("runs");
        assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
        let process = format!("in use by the run with process number {}", first.id());
        assert!(stderr(&output).contains(&process), "{}", stderr(&output));
    }
    assert!(info(&out).contains("running"), "{}", info(&out));
    first.kill().expect("it runs");
    first.wait().expect("it ends");
    assert!(info(&out).contains("killed"), "{}", info(&out));
    // What is there is not overwritten without being asked.
    let output = run_in(&scene, &out).output().expect("runs");
    assert_eq!(output.status.code(), Some(4));
    assert!(stderr(&output).contains("--resume"), "{}", stderr(&output));
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_file(folder.path(), SCENE);
    // A folder inside or in the place of a file: no one may write there, not even the system's
    // owner.
    for out in [scene.join("out"), scene.clone()] {
        let output = run_in(&scene, &out).output().expect("runs");
        assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
        let words = format!("cannot make the folder {}: ", out.display());
        assert!(stderr(&output).contains(&words), "{}", stderr(&output));
        assert!(stderr(&output).contains("choose another folder"), "{}", stderr(&output));
    }
}

#[test]
fn a_folder_without_a_run_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_file(folder.path(), SCENE);
    for place in [folder.path(), &scene, &folder.path().join("nowhere")] {
        let output = rapunzel().arg("info").arg(place).output().expect("runs");
        assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
        assert!(stderr(&output).contains("holds no run"), "{}", stderr(&output));
    }
    fs::write(folder.path().join("summary.json"), "{\"outcome\":").expect("writable");
    let output = rapunzel().arg("info").arg(folder.path()).output().expect("runs");
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    assert!(stderr(&output).contains("resume the run"), "{}", stderr(&output));
}

#[test]
fn a_scene_that_is_not_text_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.ron");
    fs::write(&path, [0xff, 0xfe, 0x00]).expect("writable");
    let output = rapunzel().arg("check").arg(&path).output().expect("runs");
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    assert!(stderr(&output).contains("no text in UTF-8"), "{}", stderr(&output));
}

/// On a disk of its own, which takes a name space of the system: where there is none to be had,
/// this says so.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_stops_the_run_until_there_is_space() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_file(folder.path(), SCENE);
    let [disk, copy, whole] = ["disk", "copy", "whole"].map(|name| folder.path().join(name));
    fs::create_dir(&disk).expect("a folder");
    let script = r#"
        mount -t tmpfs -o size=$4 tmpfs "$2" || exit 77
        "$0" run "$1" --out "$2/out"
        code=$?
        "$0" info "$2/out"
        mount -o remount,size=64m "$2" && "$0" run "$1" --out "$2/out" --resume && cp -r "$2/out" "$3"
        exit $code"#;
    // From where nothing but the start has room to where nearly all has.
    for (size, room) in [("100k", "a checkpoint"), ("200k", "some frames"), ("300k", "frames")] {
        let _ = fs::remove_dir_all(&copy);
        let mut command = std::process::Command::new("unshare");
        command.args(["--mount", "--map-root-user", "sh", "-c", script]);
        command.arg(env!("CARGO_BIN_EXE_rapunzel")).args([&scene, &disk, &copy]).arg(size);
        let output = match command.output() {
            Ok(output) if output.status.code() != Some(77) => output,
            skipped => {
                // Past the capture of the test runner: nobody shall take this for passed.
                let words = format!("SKIPPED: no disk of its own can be had here: {skipped:?}\n");
                std::io::stderr().write_all(words.as_bytes()).expect("somebody listens");
                return;
            }
        };
        assert_eq!(output.status.code(), Some(4), "{room}: {}", stderr(&output));
        assert!(stderr(&output).contains("free some space and resume"), "{}", stderr(&output));
        if !whole.exists() {
            assert!(run_in(&scene, &whole).status().expect("runs").success());
        }
        for file in ["energies.csv", "frames/frame-000015.vtp", "summary.json"] {
            let read = |folder: &Path| fs::read(folder.join(file)).expect("readable");
            assert!(read(&copy) == read(&whole), "{file} differs");
        }
    }
}

#[test]
fn a_scene_that_cannot_be_built_costs_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let good = scene_file(folder.path(), SCENE);
    let out = folder.path().join("out");
    assert!(run_in(&good, &out).status().expect("runs").success());
    let results = |name: &str| fs::read(out.join(name)).expect("readable");
    let before = ["energies.csv", "frames/frame-000015.vtp", "scene.ron"].map(results);
    let broken = folder.path().join("broken.ron");
    let object = "objects: [(shape: Mesh(file: \"missing.obj\", spacing: 0.002))], \
                  contact: (friction: Isotropic(0.3)), stepper:";
    fs::write(&broken, SCENE.replace("stepper:", object)).expect("writable");
    let output = run_in(&broken, &out).arg("--force").output().expect("runs");
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    assert_eq!(["energies.csv", "frames/frame-000015.vtp", "scene.ron"].map(results), before);
    // The user's scene lies where that of the run would.
    let text = fs::read(&good).expect("readable");
    let output = run_in(&good, folder.path()).arg("--force").output().expect("runs");
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    assert!(stderr(&output).contains("scene.ron"), "{}", stderr(&output));
    assert_eq!(fs::read(&good).expect("readable"), text);
    assert!(!folder.path().join("frames").exists());
    // A good one replaces the run.
    let longer = folder.path().join("longer.ron");
    fs::write(&longer, SCENE.replace("duration: 0.5", "duration: 0.6")).expect("writable");
    assert!(run_in(&longer, &out).arg("--force").status().expect("runs").success());
    assert!(info(&out).contains("19 frames"), "{}", info(&out));
}

#[cfg(unix)]
#[test]
fn links_are_not_followed() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_file(folder.path(), SCENE);
    let elsewhere = folder.path().join("elsewhere");
    fs::create_dir(&elsewhere).expect("a folder");
    let notes = elsewhere.join("frame-000001.vtp");
    fs::write(&notes, "field notes").expect("writable");
    for (i, (name, to)) in [("frames", &elsewhere), (".lock", &notes), ("energies.csv", &notes)]
        .into_iter()
        .enumerate()
    {
        let out = folder.path().join(format!("out-{i}"));
        fs::create_dir(&out).expect("a folder");
        symlink(to, out.join(name)).expect("links");
        for option in ["--force", "--resume"] {
            let output = run_in(&scene, &out).arg(option).output().expect("runs");
            assert_eq!(output.status.code(), Some(4), "{name}: {}", stderr(&output));
            assert_eq!(fs::read_to_string(&notes).expect("still there"), "field notes");
            assert_eq!(fs::read_dir(&elsewhere).expect("still there").count(), 1);
        }
    }
}

/// A step that takes minutes.
#[cfg(unix)]
#[test]
fn an_interrupt_ends_a_run_within_a_step() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "(
        format: 1, duration: 10,
        mass_spring: (
            model: Rope(nodes: 400, spacing: 0.05, direction: (0, 0, -1)),
            mass: 0.01, frequency: 40, substeps: 1000000,
        ),
        stepper: (dt: 1),
        output: (frame_rate: 1),
    )";
    let (scene, out) = (scene_file(folder.path(), text), folder.path().join("out"));
    let child = run_in(&scene, &out).stderr(Stdio::piped()).spawn().expect("starts");
    wait_for(&out.join("checkpoint-next.bin"));
    let pid = child.id().to_string();
    std::process::Command::new("kill").args(["-INT", &pid]).status().expect("sends a signal");
    let output = child.wait_with_output().expect("ends");
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    assert!(stderr(&output).contains("within a step"), "{}", stderr(&output));
}

#[cfg(target_os = "linux")]
#[test]
fn words_that_cannot_be_written_do_no_harm() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_file(folder.path(), SCENE);
    let full = || fs::File::options().write(true).open("/dev/full").expect("a full device");
    let out = folder.path().join("out");
    let output = run_in(&scene, &out).stdout(full()).output().expect("runs");
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    assert!(stderr(&output).contains("cannot write to the standard output"), "{}", stderr(&output));
    assert!(info(&out).contains("complete"), "the run itself is done: {}", info(&out));
    let wrong = rapunzel().args(["check", "none.ron"]).stderr(full()).output().expect("runs");
    assert_eq!(wrong.status.code(), Some(4));
    // A reader that stops reading.
    let mut check = rapunzel();
    let mut check = check.arg("check").arg(&scene).stdout(Stdio::piped()).spawn().expect("starts");
    drop(check.stdout.take());
    assert!(check.wait().expect("ends").success());
}

#[cfg(unix)]
#[test]
fn a_file_that_cannot_grow_stops_the_run_until_it_can() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_file(folder.path(), SCENE);
    let (out, whole) = (folder.path().join("out"), folder.path().join("whole"));
    // A limit on the size of files, in blocks: as a full disk, but within one process.
    let limited = format!(
        "trap '' XFSZ; ulimit -f 30; exec {} run {} --out {}",
        env!("CARGO_BIN_EXE_rapunzel"),
        scene.display(),
        out.display()
    );
    let output = std::process::Command::new("sh").args(["-c", &limited]).output().expect("runs");
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    assert!(stderr(&output).contains("raise the limit on file sizes"), "{}", stderr(&output));

    assert!(run_in(&scene, &out).arg("--resume").status().expect("runs").success());
    assert!(run_in(&scene, &whole).status().expect("runs").success());
    for file in ["energies.csv", "frames/frame-000015.vtp", "fibers.usda", "preview.png"] {
        let read = |folder: &Path| fs::read(folder.join(file)).expect("readable");
        assert!(read(&out) == read(&whole), "{file} differs");
    }
}

#[test]
fn a_step_that_fails_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = SCENE.replace(
        "motion: Swing(angle: 30, radius: 0.05, period: 0.2)",
        "tip: Pulled(velocity: (0, 0, -1), until: 1)",
    );
    let scene = scene_file(folder.path(), &text);
    let out = folder.path().join("out");
    let output = run_in(&scene, &out).output().expect("runs");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("which cannot stretch"), "{}", stderr(&output));
    assert!(out.join("checkpoint.bin").exists() && out.join("summary.json").exists());
    let log = fs::read_to_string(out.join("run.log")).expect("a log");
    assert!(log.contains("ERROR") && log.contains("which cannot stretch"), "{log}");
}

#[test]
fn a_fibre_that_does_not_converge_stops_the_run() {
    let folder = tempfile::tempdir().expect("a folder");
    // After 0.25 s, the moment on the fourth fibre, of 6 mm segments, asks for a radius of
    // curvature of 8 nm.
    let text = SCENE.replace(
        ")],\n    stepper",
        "), (
            length: 0.05, segments: 8, section: Circle(radius: 4e-5),
            tip: Loaded(moment: (
                value: (1.0, 0, 0), profile: Linear(points: [(0.25, 0), (0.26, 1)]),
            )),
        )],\n    stepper",
    );
    let (scene, out) = (scene_file(folder.path(), &text), folder.path().join("out"));
    let output = run_in(&scene, &out).output().expect("runs");
    let words = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{words}");
    assert!(words.contains("error: the run stopped at t = 0.2"), "{words}");
    assert!(words.contains("fibre 3: Newton's method did not converge"), "{words}");
    let residuals = words.split_once("residuals [").and_then(|(_, rest)| rest.split_once(']'));
    let (residuals, advice) = residuals.expect("a history");
    assert!(residuals.split(", ").filter_map(|x| x.parse::<f64>().ok()).count() > 1, "{words}");
    assert!(advice.contains("Use a smaller step"), "{words}");

    // What there is up to the frame before is kept, and the run goes on from there.
    assert!(info(&out).contains("fibre 3") && info(&out).contains("8 frames"), "{}", info(&out));
    assert!(out.join("checkpoint.bin").exists() && out.join("frames/frame-000007.vtp").exists());
    let again = run_in(&scene, &out).arg("--resume").output().expect("runs");
    assert_eq!((again.status.code(), stderr(&again)), (Some(1), words));
}

#[test]
fn templates_are_sound_and_not_overwritten() {
    let folder = tempfile::tempdir().expect("a folder");
    let new = |options: &[&str]| {
        let mut command = rapunzel();
        command.current_dir(folder.path()).args(["new", "buckling"]).args(options);
        command.output().expect("runs").status.code()
    };
    assert_eq!([new(&[]), new(&[]), new(&["--force"])], [Some(0), Some(4), Some(0)]);
    let path = folder.path().join("buckling.ron");
    assert!(rapunzel().arg("check").arg(path).status().expect("runs").success());
    let named = [("mass-spring/rope", "rope.ron"), ("contact/head", "standing.ron")];
    for (name, file) in named.into_iter().chain([("charge/half-head", "head.obj")]) {
        let made = rapunzel().current_dir(folder.path()).args(["new", name]).status();
        assert!(made.expect("runs").success() && folder.path().join(file).exists(), "{name}");
    }
    let checked = rapunzel().arg("check").arg(folder.path().join("rope.ron")).output();
    let checked = String::from_utf8(checked.expect("runs").stdout).expect("text");
    assert!(checked.contains("nodes     40, of a mass-spring system"), "{checked}");
    assert!(!fs::read_to_string(folder.path().join("head.ron")).expect("a scene").contains(".."));
    let unknown = rapunzel().args(["new", "wig"]).output().expect("runs");
    assert_eq!(unknown.status.code(), Some(2));
    assert!(stderr(&unknown).contains("lock-under-gravity"), "the list: {}", stderr(&unknown));
    let none = rapunzel().arg("new").output().expect("runs");
    assert_eq!(none.status.code(), Some(2));
    assert!(stderr(&none).contains("lock-on-moving-root"), "the list: {}", stderr(&none));
    let nowhere = folder.path().join("nowhere/scene.ron");
    let nowhere = rapunzel().args(["new", "buckling"]).arg(nowhere).output().expect("runs");
    assert_eq!(nowhere.status.code(), Some(4));
    assert!(stderr(&nowhere).contains("make the folder first"), "{}", stderr(&nowhere));
}
