use super::*;
use crate::folder_lock::in_use;
use crate::manifest::Entry;
use proptest::prelude::*;

#[test]
fn a_folder_has_one_run_at_a_time() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let path = temporary.path();
    let first = RunFolder::open(path, Existing::Refuse).expect("empty");
    for existing in [Existing::Refuse, Existing::Resume, Existing::Overwrite] {
        let error = RunFolder::open(path, existing).expect_err("in use").to_string();
        assert!(error.contains(&std::process::id().to_string()), "{error}");
    }
    assert!(in_use(path));
    drop(first);
    assert!(!in_use(path));
    RunFolder::open(path, Existing::Refuse).expect("free again");
}

#[test]
fn a_stale_lock_is_taken_over() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    fs::write(temporary.path().join(LOCK), "1\n").expect("writes");
    RunFolder::open(temporary.path(), Existing::Refuse).expect("nobody holds the lock");
}

#[test]
fn a_run_that_was_killed_at_once_leaves_nothing_in_the_way() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    fs::write(temporary.path().join(".rapunzel.partial"), "# The fi").expect("writes");
    for existing in [Existing::Resume, Existing::Refuse] {
        RunFolder::open(temporary.path(), existing).expect("nothing is there");
    }
}

#[test]
fn a_lock_of_somebody_else_is_left_alone() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let path = temporary.path().join(LOCK);
    fs::write(&path, "the key is under the mat").expect("writes");
    let refused = RunFolder::open(temporary.path(), Existing::Overwrite);
    assert!(matches!(refused, Err(SimError::ForeignFile(_))), "{refused:?}");
    assert_eq!(fs::read_to_string(&path).expect("readable"), "the key is under the mat");
}

/// The files of a small run.
fn small() -> Manifest {
    [SCENE.into(), SUMMARY.into(), CHECKPOINT.into(), Entry::series("frames/frame", "vtp", 3)]
        .into_iter()
        .collect()
}

/// Opens a folder and writes a run with two frames into it.
fn make_run(path: &Path, existing: Existing, text: &str) -> Result<RunFolder, SimError> {
    let mut folder = RunFolder::open(path, existing)?;
    folder.begin(&small())?;
    for name in [SCENE, SUMMARY, CHECKPOINT, "frames/frame-000000.vtp", "frames/frame-000001.vtp"] {
        fs::write(folder.file(name), text).expect("writes");
    }
    Ok(folder)
}

fn tree(path: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    for name in names(path).expect("readable") {
        let whole = path.join(&name);
        if whole.is_dir() {
            let within = tree(&whole).into_iter();
            found.extend(within.map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else if name != LOCK {
            found.push((name, fs::read(&whole).expect("readable")));
        }
    }
    found.sort();
    found
}

#[test]
fn an_older_run_stays_until_the_new_one_takes_its_place() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let path = temporary.path();
    drop(make_run(path, Existing::Refuse, "old").expect("an empty folder"));
    let theirs = ["thesis.tex", "frames/frame-000007.vtp", "frames/frame-000001.png"];
    theirs.iter().for_each(|name| fs::write(path.join(name), "theirs").expect("writes"));
    let before = tree(path);
    for existing in [Existing::Refuse, Existing::Overwrite] {
        // Opened and dropped, as where a scene cannot be built.
        assert_eq!(RunFolder::open(path, existing).is_ok(), existing == Existing::Overwrite);
        assert_eq!(tree(path), before);
    }
    drop(make_run(path, Existing::Overwrite, "dropped").expect("over a run"));
    assert_eq!(tree(path), before, "a run without a frame leaves nothing");
    let mut folder = make_run(path, Existing::Overwrite, "new").expect("over a run");
    assert!(folder.holds_older_run() && folder.exchange().expect("exchanges"));
    assert!(!folder.holds_older_run() && !folder.exchange().expect("nothing to do"));
    let new = |bytes: Vec<u8>| if bytes == b"old" { b"new".to_vec() } else { bytes };
    let after: Vec<_> = before.into_iter().map(|(name, bytes)| (name, new(bytes))).collect();
    assert_eq!(tree(path), after);
}

/// Wherever a kill stops it: all files that were to be moved are in one of both places.
#[test]
fn an_exchange_that_was_killed_goes_on() {
    let whole = tempfile::tempdir().expect("a temporary folder");
    drop(make_run(whole.path(), Existing::Refuse, "new").expect("an empty folder"));
    let whole = tree(whole.path());
    for stop in 0..=whole.len() {
        let temporary = tempfile::tempdir().expect("a temporary folder");
        let path = temporary.path();
        drop(make_run(path, Existing::Refuse, "old").expect("an empty folder"));
        let folder = make_run(path, Existing::Overwrite, "new").expect("over a run");
        let ready = path.join(READY);
        fs::rename(&folder.files, &ready).expect("renames");
        drop(folder);
        if stop > 0 {
            clear(path, &small()).expect("removes");
            remove(&path.join(MANIFEST)).expect("removes");
            make_folders(path, &small()).expect("makes");
            // The list comes last.
            let mut moved: Vec<_> = whole.iter().map(|(name, _)| name.as_str()).collect();
            moved.sort_by_key(|name| *name == MANIFEST);
            for name in &moved[..stop] {
                fs::rename(ready.join(name), path.join(name)).expect("renames");
            }
        }
        drop(RunFolder::open(path, Existing::Resume).expect("goes on"));
        assert_eq!(tree(path), whole, "killed after {stop}");
        assert!(!ready.exists());
    }
}

#[test]
fn results_are_not_lost_by_resuming_without_a_checkpoint() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let path = temporary.path();
    drop(make_run(path, Existing::Refuse, "old").expect("an empty folder"));
    fs::remove_file(path.join(CHECKPOINT)).expect("removes");
    let refused = RunFolder::open(path, Existing::Resume);
    assert!(matches!(refused, Err(SimError::NoCheckpoint(_))), "{refused:?}");
    // One that was killed before its first summary has none to lose.
    fs::remove_file(path.join(SUMMARY)).expect("removes");
    RunFolder::open(path, Existing::Resume).expect("starts anew");
}

#[test]
fn what_is_read_and_what_is_not_listed_is_not_overwritten() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let path = temporary.path();
    let scene = path.join(SCENE);
    fs::write(&scene, "a day's work").expect("writes");
    let refused = make_run(path, Existing::Overwrite, "new");
    assert!(matches!(refused, Err(SimError::ForeignFile(_))), "{refused:?}");
    fs::remove_file(&scene).expect("removes");
    drop(make_run(path, Existing::Overwrite, "a run").expect("nothing in its way"));
    let mut folder = RunFolder::open(path, Existing::Overwrite).expect("over a run");
    folder.protect(&path.join(".").join(SCENE));
    let refused = folder.begin(&small());
    assert!(matches!(refused, Err(SimError::OverInput(_))), "{refused:?}");
    drop(folder);
    assert_eq!(fs::read(&scene).expect("readable"), b"a run");
}

#[test]
fn an_answer_replaces_an_answer_and_nothing_else() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let path = temporary.path();
    let answer = |files: &[&str], text: &str| -> Result<(), SimError> {
        claim(path, files)?;
        files.iter().for_each(|name| fs::write(path.join(name), text).expect("writes"));
        Ok(())
    };
    answer(&["rod-0.csv", "rod-1.csv"], "old").expect("an empty folder");
    fs::write(path.join("notes.txt"), "theirs").expect("writes");
    answer(&["rod-0.csv"], "new").expect("over an answer");
    assert_eq!(names(path).expect("readable").len(), 3, "the list, the new file and theirs");
    let refused = answer(&["rod-0.csv", "notes.txt"], "newer");
    assert!(matches!(refused, Err(SimError::ForeignFile(_))), "{refused:?}");
    assert_eq!(fs::read(path.join("rod-0.csv")).expect("still there"), b"new");
    let other = tempfile::tempdir().expect("a temporary folder");
    drop(make_run(other.path(), Existing::Refuse, "a run").expect("an empty folder"));
    let refused = claim(other.path(), &["rod-0.csv"]);
    assert!(matches!(refused, Err(SimError::FolderNotEmpty(_))), "{refused:?}");
}

#[cfg(unix)]
proptest! {
    /// Links and files anywhere in a folder, with any names of ours: whatever becomes of the run,
    /// nothing outside changes and nothing foreign does.
    #[test]
    fn planted_files_and_links_are_not_touched(
        planted in prop::collection::vec((0..8_usize, 0..3_u8), 0..4),
        has_run: bool,
        existing in prop::sample::select(
            vec![Existing::Refuse, Existing::Resume, Existing::Overwrite]
        ),
    ) {
        const PLACES: [&str; 8] = [
            ".lock", ".rapunzel", "scene.ron", "summary.json", "frames",
            "frames/frame-000000.vtp", "checkpoint.bin.partial", ".rapunzel-staged",
        ];
        let temporary = tempfile::tempdir().expect("a temporary folder");
        let (path, outside) = (temporary.path().join("run"), temporary.path().join("outside"));
        fs::create_dir(&outside).expect("makes");
        let precious = outside.join("frame-000000.vtp");
        fs::write(&precious, "field notes").expect("writes");
        fs::create_dir(&path).expect("makes");
        if has_run {
            drop(make_run(&path, Existing::Refuse, "old").expect("an empty folder"));
        }
        let mut foreign = Vec::new();
        for (place, kind) in planted {
            let at = path.join(PLACES[place]);
            if at.symlink_metadata().is_ok() || !at.parent().is_some_and(Path::is_dir) {
                continue;
            }
            match kind {
                0 => std::os::unix::fs::symlink(&precious, &at).expect("links"),
                1 => std::os::unix::fs::symlink(&outside, &at).expect("links"),
                // What a kill leaves has this name: a foreign file with it is taken for that.
                _ if PLACES[place].ends_with(".partial") => {}
                _ => {
                    fs::write(&at, "foreign").expect("writes");
                    foreign.push(at);
                }
            }
        }
        if let Ok(mut folder) = make_run(&path, existing, "new") {
            let _ = folder.exchange();
        }
        prop_assert_eq!(fs::read(&precious).expect("still there"), b"field notes");
        prop_assert_eq!(names(&outside).expect("readable").len(), 1);
        for at in foreign {
            prop_assert_eq!(fs::read(&at).expect("still there"), b"foreign", "{}", at.display());
        }
    }
}
