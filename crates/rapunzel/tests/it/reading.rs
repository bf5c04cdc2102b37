//! What the program does with files and numbers that no run should come from.

use crate::common::{SCENE, rapunzel, run_in, scene_file};
use std::fs;
use std::process::Output;

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_byte_order_mark_is_taken() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_file(folder.path(), &format!("\u{feff}{SCENE}"));
    let output = rapunzel().arg("check").arg(&scene).output().expect("runs");
    assert!(output.status.success(), "{}", told(&output));
}

#[test]
fn what_does_not_fit_is_refused_with_its_size() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_file(folder.path(), SCENE);
    for command in ["check", "run"] {
        let output = rapunzel().arg(command).arg(&scene).args(["--memory", "1e-5"]).output();
        let output = output.expect("runs");
        assert_eq!(output.status.code(), Some(3), "{}", told(&output));
        assert!(told(&output).contains("fibers[0]: 3 fibres of 8 segments"), "{}", told(&output));
    }
    assert!(!folder.path().join("runs").exists(), "nothing was begun");
}

#[test]
fn threads_are_cut_to_what_the_machine_bears() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = scene_file(folder.path(), &SCENE.replace("duration: 0.5", "duration: 0.01"));
    let out = folder.path().join("out");
    let output = run_in(&scene, &out).args(["--threads", "65535"]).output().expect("runs");
    assert!(output.status.success(), "{}", told(&output));
    assert!(told(&output).contains("65535 threads"), "{}", told(&output));
}

#[cfg(unix)]
#[test]
fn devices_pipes_and_huge_files_are_not_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mesh.obj");
    let objects = "objects: [(shape: Mesh(file: \"mesh.obj\", spacing: 1e-3))], \
        contact: (friction: Isotropic(0.3)), stepper";
    let scenes = [
        SCENE.replace("stepper", objects),
        SCENE.replace(
            "motion:",
            "initial: Knot(curve: File(\"mesh.obj\"), scale: 1e-3, spacing: 1e-3), motion:",
        ),
    ];
    for text in scenes {
        let scene = scene_file(folder.path(), &text);
        let check = |what: &str| {
            let output = rapunzel().arg("check").arg(&scene).output().expect("runs");
            assert_eq!(output.status.code(), Some(4), "{what}: {}", told(&output));
            fs::remove_file(&path).expect("there");
            told(&output)
        };
        std::os::unix::fs::symlink("/dev/zero", &path).expect("a link");
        assert!(check("a device").contains("no file"));
        let made = std::process::Command::new("mkfifo").arg(&path).status().expect("runs");
        assert!(made.success());
        assert!(check("a pipe").contains("no file"));
        let sparse = fs::File::create(&path).and_then(|file| file.set_len(20_000_000_000));
        sparse.expect("a sparse file");
        assert!(check("a sparse file").contains("20000 MB"));
    }
}
