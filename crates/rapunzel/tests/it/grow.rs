//! Styles grown by the program.

use crate::common::{rapunzel, wait_for};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

/// A command that grows a style into `out`.
fn grow_in(folder: &Path, text: &str, out: &Path) -> Command {
    let style = folder.join("style.ron");
    fs::write(&style, text).expect("writable");
    let mut command = rapunzel();
    command.arg("grow").arg(style).arg("--out").arg(out);
    command
}

/// What a folder holds, by name.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let paths = fs::read_dir(folder).expect("a folder").flatten().map(|entry| entry.path());
    let name = |path: &Path| PathBuf::from(path.file_name().expect("a name"));
    paths.map(|path| (name(&path), fs::read(&path).expect("readable"))).collect()
}

/// Kills while files are written, in a new folder and in one with what an older kill left.
#[test]
fn a_killed_grow_leaves_whole_files_or_none() {
    let folder = tempfile::tempdir().expect("a folder");
    let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
    let text = "(hairs: 2000, guides: 20, pre_guides: 1000)";
    assert!(grow_in(folder.path(), text, &whole).status().expect("runs").success());
    let whole = files(&whole);
    let mut kills = 0;
    for i in 0..8 {
        let mut command = grow_in(folder.path(), text, &parts);
        let mut child =
            command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("starts");
        // The list of the files is written before them.
        wait_for(&parts.join(".rapunzel"));
        std::thread::sleep(Duration::from_millis(5 * i));
        child.kill().expect("a child");
        kills += u32::from(!child.wait().expect("ends").success());
        let left = files(&parts);
        for (name, bytes) in &left {
            let is_partial = name.extension().is_some_and(|ending| ending == "partial");
            assert!(is_partial || whole.get(name) == Some(bytes), "{} is cut off", name.display());
        }
        if i % 2 == 0 {
            fs::remove_dir_all(&parts).expect("removes");
        }
    }
    assert!(kills >= 4, "only {kills} of 8 were killed before their end");
    assert!(grow_in(folder.path(), text, &parts).status().expect("runs").success());
    assert!(files(&parts) == whole, "what was left over is gone, all else is there");
}

#[test]
fn a_wrong_style_is_told_and_nothing_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    fs::write(folder.path().join("flat.obj"), "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 3 2\n")
        .expect("writable");
    for (text, words) in [
        ("(guides: 0)", "the number of guides is 0, but must be between 1 and 100000"),
        ("(length: Constant(0.0))", "the length of the hairs (m) is 0"),
        ("(hairs: 1, hair: Scan)", "give `head: Scan(..)`"),
        ("(scalp: \"none.obj\")", "none.obj"),
        ("(scalp: \"flat.obj\")", "the scalp lies"),
        ("(head: Mesh(file: \"flat.obj\"))", "the head: "),
        ("(hairs: 1, colour: 3)", "style.ron:1:"),
    ] {
        let output = grow_in(folder.path(), text, &out).output().expect("runs");
        let told = String::from_utf8_lossy(&output.stderr).replace("\n  │ ", " ");
        assert_eq!(output.status.code(), Some(3), "{text}: {told}");
        assert!(told.contains(words), "{text}: {told}");
        assert!(!out.exists(), "{text}");
    }
}

#[test]
fn what_was_mended_can_be_read_by_machines() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    // A cube about the head, inside out and without a lid: the hull of a wide style.
    let corners =
        "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\n";
    let faces = "f 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 1 3 4 2\nf 5 6 8 7\n";
    let cube: String = corners.replace('1', "0.2");
    let turned: String = faces
        .lines()
        .map(|line| {
            let mut words: Vec<_> = line.split(' ').skip(1).collect();
            words.reverse();
            format!("f {}\n", words.join(" "))
        })
        .collect();
    fs::write(folder.path().join("cube.obj"), cube + &turned).expect("writable");
    let text = "(hair: Solid(\"cube.obj\"), hairs: 100, guides: 10, pre_guides: 500,
        length: Constant(0.05))";
    let output = grow_in(folder.path(), text, &out).arg("--json").output().expect("runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let object: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let mended = object["report"]["mended"]["the hair"].as_str().expect("told");
    assert!(mended.contains("faces turned") && mended.contains("holes closed: 1"), "{mended}");
    assert_eq!(object["report"]["crossed"], serde_json::json!([]));
}
