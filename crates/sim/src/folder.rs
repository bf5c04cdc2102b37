use crate::SimError;
use crate::storage::PARTIAL;
use std::fs::{self, File, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};

/// What to do with a folder that already holds something.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Existing {
    /// Refuse it.
    #[default]
    Refuse,
    /// Go on with the run in it.
    Resume,
    /// Remove the files of the run in it, and only those, and start anew.
    Overwrite,
}

/// The folder of a run, held by this process alone until it is dropped.
///
/// It holds `scene.ron` (the scene with all defaults), `summary.json`, `energies.csv`, `contacts.csv`,
/// `charge.csv`, `probes.csv`, `objects.csv`, `frames.pvd` with `frames/frame-*.vtp` and, of objects, `frames/objects-*.vtp` (one
/// file where none of them moves), `preview.png`, the formats that the scene
/// asks for, `checkpoint.bin`, and `run.log` if the program keeps one.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
    /// Holds the operating system's lock, which goes when the process does, however it ends: a
    /// lock file without that lock is stale. The file stays, because removing it would race with
    /// the next process that locks it.
    _lock: File,
}

pub(crate) const SCENE: &str = "scene.ron";
pub(crate) const CHECKPOINT: &str = "checkpoint.bin";
pub(crate) const ENERGIES: &str = "energies.csv";
pub(crate) const CONTACTS: &str = "contacts.csv";
pub(crate) const CHARGE: &str = "charge.csv";
pub(crate) const PROBES: &str = "probes.csv";
pub(crate) const OBJECTS: &str = "objects.csv";
pub(crate) const SUMMARY: &str = "summary.json";
pub(crate) const PVD: &str = "frames.pvd";
pub(crate) const PREVIEW: &str = "preview.png";
pub(crate) const USD: &str = "fibers.usda";
pub(crate) const OBJECTS_USD: &str = "objects.usda";
/// The files of a run beside the frames.
const FILES: [&str; 13] = [
    SCENE,
    CHECKPOINT,
    ENERGIES,
    CONTACTS,
    CHARGE,
    PROBES,
    OBJECTS,
    SUMMARY,
    PVD,
    PREVIEW,
    USD,
    OBJECTS_USD,
    "run.log",
];
pub(crate) const FRAMES: &str = "frames";
const LOCK: &str = ".lock";

impl RunFolder {
    /// Takes hold of a folder, which is made if it is not there.
    ///
    /// # Errors
    /// [`SimError::FolderInUse`], [`SimError::FolderNotEmpty`], or [`SimError::Io`].
    pub fn open(path: &Path, existing: Existing) -> Result<Self, SimError> {
        fs::create_dir_all(path).map_err(SimError::io("make the folder", path))?;
        let folder = Self { path: path.to_owned(), _lock: lock(path)? };
        let files = fs::read_dir(path).map_err(SimError::io("read the folder", path))?;
        let names = files.flatten().map(|file| file.file_name().to_string_lossy().into_owned());
        let foreign = |name: &String| {
            let name = name.trim_end_matches(PARTIAL);
            ![LOCK, FRAMES].contains(&name) && !FILES.contains(&name)
        };
        let refused = match existing {
            Existing::Refuse => names.into_iter().any(|name| name != LOCK),
            // A run that was killed early has not written its scene yet.
            Existing::Resume => {
                !folder.file(SCENE).exists() && names.into_iter().any(|n| foreign(&n))
            }
            Existing::Overwrite => false,
        };
        if refused {
            return Err(SimError::FolderNotEmpty(path.to_owned()));
        }
        if existing == Existing::Overwrite {
            folder.clear()?;
        }
        Ok(folder)
    }

    /// Where the folder is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The path of a file in the folder.
    #[must_use]
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    fn clear(&self) -> Result<(), SimError> {
        let frames = fs::read_dir(self.file(FRAMES)).into_iter().flatten().flatten();
        let frames = frames
            .filter(|file| {
                let name = file.file_name().to_string_lossy().into_owned();
                ["frame-", "objects-", "field-"].iter().any(|kind| name.starts_with(kind))
            })
            .map(|file| file.path());
        let files = frames.chain(FILES.iter().map(|name| self.file(name)));
        for file in files.filter(|file| file.exists()) {
            fs::remove_file(&file).map_err(SimError::io("remove", &file))?;
        }
        Ok(())
    }
}

/// Takes the lock of a folder and writes this process's number into it.
fn lock(folder: &Path) -> Result<File, SimError> {
    let path = folder.join(LOCK);
    let mut file = File::options()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .open(&path)
        .map_err(SimError::io("write", &path))?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            let mut process = String::new();
            // Only for the message; the holder may be about to write it.
            let _ = file.read_to_string(&mut process);
            let (path, process) = (folder.to_owned(), process.trim().to_owned());
            return Err(SimError::FolderInUse { path, process });
        }
        Err(TryLockError::Error(source)) => return Err(SimError::io("lock", &path)(source)),
    }
    let number = format!("{}\n", std::process::id());
    file.set_len(0)
        .and_then(|()| file.rewind())
        .and_then(|()| file.write_all(number.as_bytes()))
        .map_err(SimError::io("write", &path))?;
    Ok(file)
}

/// Whether a run holds the folder now.
#[must_use]
pub fn in_use(folder: &Path) -> bool {
    File::open(folder.join(LOCK))
        .is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn only_files_of_a_run_are_removed() {
        let temporary = tempfile::tempdir().expect("a temporary folder");
        let (ours, theirs) = (temporary.path().join(SCENE), temporary.path().join("thesis.tex"));
        fs::write(&ours, "()").expect("writes");
        fs::write(&theirs, "years of work").expect("writes");
        let refused = RunFolder::open(temporary.path(), Existing::Refuse);
        assert!(matches!(refused, Err(SimError::FolderNotEmpty(_))), "{refused:?}");
        RunFolder::open(temporary.path(), Existing::Overwrite).expect("may be overwritten");
        assert!(!ours.exists() && theirs.exists());
        let refused = RunFolder::open(temporary.path(), Existing::Resume);
        assert!(matches!(refused, Err(SimError::FolderNotEmpty(_))), "{refused:?}");
    }
}
