use crate::SimError;
use crate::folder_lock::{LOCK, lock};
use crate::manifest::Manifest;
use crate::storage::{PARTIAL, require_plain, sync, write_atomically};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// What to do with a folder that already holds something.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Existing {
    /// Refuse it.
    #[default]
    Refuse,
    /// Go on with the run in it.
    Resume,
    /// Start anew. The files of the run in it, and only those, go when the new run has its first
    /// frame after the start.
    Overwrite,
}

/// The folder of a run, held by this process alone until it is dropped.
///
/// It holds `scene.ron` (the scene with all defaults), `summary.json`, `energies.csv`,
/// `contacts.csv`, `charge.csv`, `probes.csv`, `objects.csv`, `frames.pvd` with
/// `frames/frame-*.vtp` and, of objects, `frames/objects-*.vtp` (one file where none of them
/// moves), `preview.png`, the formats that the scene asks for, `checkpoint.bin`, and `run.log` if
/// the program keeps one. The file `.rapunzel` lists all of them, before they are written: what it
/// does not list is somebody else's, and is never changed. Links are not followed.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
    /// Where the files of the run are: the folder, or the one in it for a run that is to take the
    /// place of an older one.
    files: PathBuf,
    /// What the older run lists.
    old: Option<Manifest>,
    /// Files that are read, and must not be written.
    inputs: Vec<PathBuf>,
    /// Holds the operating system's lock, which goes when the process does, however it ends: a
    /// lock file without that lock is stale. The file stays, because removing it would race with
    /// the next process that locks it.
    _lock: File,
}

pub(crate) const SCENE: &str = "scene.ron";
pub(crate) const CHECKPOINT: &str = "checkpoint.bin";
/// The checkpoint of the last frame, until it is safe from a loss of power.
pub(crate) const NEXT_CHECKPOINT: &str = "checkpoint-next.bin";
pub(crate) const ENERGIES: &str = "energies.csv";
pub(crate) const CONTACTS: &str = "contacts.csv";
pub(crate) const CHARGE: &str = "charge.csv";
pub(crate) const PROBES: &str = "probes.csv";
pub(crate) const OBJECTS: &str = "objects.csv";
pub(crate) const SUMMARY: &str = "summary.json";
pub(crate) const PVD: &str = "frames.pvd";
pub(crate) const PLOTS: &str = "plots.svg";
pub(crate) const PREVIEW: &str = "preview.png";
pub(crate) const STAGE: &str = "scene.usda";
pub(crate) const USD: &str = "fibers.usda";
pub(crate) const SPRINGS_USD: &str = "springs.usda";
pub(crate) const OBJECTS_USD: &str = "objects.usda";
pub(crate) const LOG: &str = "run.log";
pub(crate) const FRAMES: &str = "frames";
const MANIFEST: &str = ".rapunzel";
/// Where a run waits for its first frame before it takes the place of an older one.
const STAGED: &str = ".rapunzel-staged";
/// Where it is once it is taking that place: a kill cannot undo this, the next run goes on with it.
const READY: &str = ".rapunzel-ready";

/// The name of a frame's file as seen from the folder of the run.
pub(crate) fn frame_name(index: usize, extension: &str) -> String {
    format!("{FRAMES}/frame-{index:06}.{extension}")
}

/// The name of a file of objects as seen from the folder of the run.
pub(crate) fn objects_name(index: usize, extension: &str) -> String {
    format!("{FRAMES}/objects-{index:06}.{extension}")
}

impl RunFolder {
    /// Takes hold of a folder, which is made if it is not there.
    ///
    /// # Errors
    /// [`SimError::FolderInUse`], [`SimError::FolderNotEmpty`], [`SimError::NoCheckpoint`],
    /// [`SimError::ForeignFile`], [`SimError::NotPlain`] for links, or [`SimError::Io`].
    pub fn open(path: &Path, existing: Existing) -> Result<Self, SimError> {
        fs::create_dir_all(path).map_err(SimError::io("make the folder", path))?;
        let lock = lock(path)?;
        finish_exchange(path)?;
        let old = read_manifest(path)?;
        // A run that could not be built leaves its log, and the list with it; one that was killed
        // at once a part of the list.
        let unlisted = format!("{MANIFEST}{PARTIAL}");
        let nothing = |name: &String| match &old {
            None => [LOCK, &unlisted].contains(&name.as_str()),
            Some(_) => [LOCK, MANIFEST, &unlisted, LOG].contains(&name.as_str()),
        };
        let is_empty = names(path)?.iter().all(nothing);
        let refused = match existing {
            Existing::Refuse => !is_empty,
            Existing::Resume => old.is_none() && !is_empty,
            Existing::Overwrite => false,
        };
        if refused {
            return Err(SimError::FolderNotEmpty(path.to_owned()));
        }
        let holds = |name: &str| path.join(name).exists();
        if existing == Existing::Resume
            // A run that was killed before its first summary has nothing to lose.
            && holds(SUMMARY)
            && ![CHECKPOINT, NEXT_CHECKPOINT].into_iter().any(holds)
        {
            return Err(SimError::NoCheckpoint(path.to_owned()));
        }
        if old.is_none() && holds(LOG) {
            return Err(SimError::ForeignFile(path.join(LOG)));
        }
        require_plain(&path.join(LOG), false)?;
        let mut files = path.to_owned();
        match &old {
            None => write_manifest(path, &Manifest::from_iter([LOG.into()]))?,
            Some(old) if existing == Existing::Overwrite => {
                files.push(STAGED);
                discard(&files)?;
                // Nothing that is worth waiting for.
                if !listed(path, old)?.iter().any(|name| name != LOG) {
                    files.pop();
                }
            }
            Some(_) => {}
        }
        Ok(Self { path: path.to_owned(), files, old, inputs: Vec::new(), _lock: lock })
    }

    /// Where the folder is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The path of a log, which is appended to whatever becomes of the run.
    #[must_use]
    pub fn log(&self) -> PathBuf {
        self.path.join(LOG)
    }

    /// Notes a file that is read: a run that would write or remove it is refused.
    pub fn protect(&mut self, input: &Path) {
        self.inputs.push(input.to_owned());
    }

    /// Whether the folder still holds an older run, whose place the new one takes with its first
    /// frame after the start.
    #[must_use]
    pub fn holds_older_run(&self) -> bool {
        self.files != self.path
    }

    /// Where the files of the run are now.
    pub(crate) fn files(&self) -> &Path {
        &self.files
    }

    /// The path of a file of the run.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.files.join(name)
    }

    /// Makes ready for the files of a new run, and lists them.
    ///
    /// # Errors
    /// [`SimError::ForeignFile`] where a file of somebody else's has the name of one,
    /// [`SimError::NotPlain`] where a link has, [`SimError::OverInput`] where it is one that is
    /// read; [`SimError::Io`].
    pub(crate) fn begin(&mut self, manifest: &Manifest) -> Result<(), SimError> {
        let old = self.old.take().unwrap_or_default();
        look_for_others(&self.path, [manifest, &old], &self.inputs)?;
        if !self.holds_older_run() {
            clear(&self.path, &old)?;
        }
        make_folders(&self.files, manifest)?;
        write_manifest(&self.files, manifest)
    }

    /// Looks for links among the files of the run that goes on.
    pub(crate) fn go_on(&mut self) -> Result<(), SimError> {
        let manifest = self.old.take().unwrap_or_default();
        listed(&self.path, &manifest)?;
        make_folders(&self.path, &manifest)
    }

    /// Removes the older run and puts the new one into its place; false if there is none.
    pub(crate) fn exchange(&mut self) -> Result<bool, SimError> {
        if !self.holds_older_run() {
            return Ok(false);
        }
        sync(&self.path)?;
        let ready = self.path.join(READY);
        fs::rename(&self.files, &ready).map_err(SimError::io("write", &ready))?;
        self.files.clone_from(&self.path);
        finish_exchange(&self.path)?;
        Ok(true)
    }
}

impl Drop for RunFolder {
    /// Removes a run that has not come to its first frame.
    fn drop(&mut self) {
        if self.holds_older_run() {
            // Where this fails, the next run in the folder tries it again and tells.
            let _ = discard(&self.files);
        }
    }
}

/// Makes ready for the files of an answer, which are replaced each time it is found: those that the
/// folder lists go. The folder is made if it is not there.
///
/// # Errors
/// [`SimError::FolderNotEmpty`] for the folder of a run; [`SimError::ForeignFile`] and
/// [`SimError::NotPlain`] where something else has the name of a file; [`SimError::Io`].
pub fn claim(path: &Path, files: &[&str]) -> Result<(), SimError> {
    fs::create_dir_all(path).map_err(SimError::io("make the folder", path))?;
    let manifest: Manifest = files.iter().map(|&name| name.into()).collect();
    let old = read_manifest(path)?.unwrap_or_default();
    if old.owns(SCENE) {
        return Err(SimError::FolderNotEmpty(path.to_owned()));
    }
    look_for_others(path, [&manifest, &old], &[])?;
    clear(path, &old)?;
    write_manifest(path, &manifest)
}

/// Refuses what is not from here, or is read, and has the name of a file that is to come or to go.
fn look_for_others(
    path: &Path,
    [new, old]: [&Manifest; 2],
    inputs: &[PathBuf],
) -> Result<(), SimError> {
    for name in listed(path, new)? {
        if !old.owns(&name) && name != LOG {
            return Err(SimError::ForeignFile(path.join(name)));
        }
    }
    listed(path, old)?;
    let folder = path.canonicalize().map_err(SimError::io("read", path))?;
    for input in inputs {
        let whole = input.canonicalize().map_err(SimError::io("read", input))?;
        let within = whole.strip_prefix(&folder).ok().and_then(Path::to_str);
        let within = within.map(|name| name.replace(std::path::MAIN_SEPARATOR, "/"));
        if within.is_some_and(|name| new.owns(&name) || old.owns(&name)) {
            return Err(SimError::OverInput(input.clone()));
        }
    }
    Ok(())
}

/// Goes on with an exchange that was begun: the old files go, their list last, then the new ones
/// come, their list last. So each list is there as long as it is needed.
fn finish_exchange(path: &Path) -> Result<(), SimError> {
    let ready = path.join(READY);
    require_plain(&ready, true)?;
    let Some(new) = read_manifest(&ready)? else {
        // Its list has been moved last: nothing is left in it but folders.
        remove_folders(&ready, &read_manifest(path)?.unwrap_or_default());
        return Ok(());
    };
    if let Some(old) = read_manifest(path)? {
        clear(path, &old)?;
        remove(&path.join(MANIFEST))?;
    }
    make_folders(path, &new)?;
    for name in listed(&ready, &new)?.into_iter().chain([MANIFEST.into()]) {
        let to = path.join(&name);
        fs::rename(ready.join(&name), &to).map_err(SimError::io("write", &to))?;
    }
    remove_folders(&ready, &new);
    Ok(())
}

/// Removes a run that never took its place, and the folder in which it waited.
fn discard(staged: &Path) -> Result<(), SimError> {
    require_plain(staged, true)?;
    let manifest = read_manifest(staged)?.unwrap_or_default();
    clear(staged, &manifest)?;
    remove(&staged.join(MANIFEST))?;
    match fs::remove_dir(staged) {
        Err(error) if error.kind() == io::ErrorKind::DirectoryNotEmpty => {
            Err(SimError::FolderNotEmpty(staged.to_owned()))
        }
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            Err(SimError::io("remove", staged)(error))
        }
        _ => Ok(()),
    }
}

/// Removes the files of a run but its log and its list, then the folders that it leaves empty.
fn clear(path: &Path, manifest: &Manifest) -> Result<(), SimError> {
    let files = listed(path, manifest)?;
    files.iter().filter(|name| *name != LOG).try_for_each(|name| remove(&path.join(name)))?;
    for folder in manifest.folders() {
        // One that holds a file of somebody else's stays.
        let _ = fs::remove_dir(path.join(folder));
    }
    Ok(())
}

/// Removes a file, if it is there.
fn remove(file: &Path) -> Result<(), SimError> {
    match fs::remove_file(file) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            Err(SimError::io("remove", file)(error))
        }
        _ => Ok(()),
    }
}

fn make_folders(path: &Path, manifest: &Manifest) -> Result<(), SimError> {
    for folder in manifest.folders().into_iter().chain([""]) {
        let folder = path.join(folder);
        fs::create_dir_all(&folder).map_err(SimError::io("make the folder", &folder))?;
    }
    Ok(())
}

/// Removes a folder and those of a run in it, as far as they are empty.
fn remove_folders(path: &Path, manifest: &Manifest) {
    for folder in manifest.folders().into_iter().chain([""]) {
        let _ = fs::remove_dir(path.join(folder));
    }
}

/// Names of the files of a run that are in its folder, and parts of them that a kill left.
///
/// # Errors
/// [`SimError::NotPlain`] where a link or something else has the name of one.
fn listed(path: &Path, manifest: &Manifest) -> Result<Vec<String>, SimError> {
    let mut found = Vec::new();
    for folder in manifest.folders().into_iter().chain([""]) {
        let whole = path.join(folder);
        require_plain(&whole, true)?;
        let within =
            |name: String| if folder.is_empty() { name } else { format!("{folder}/{name}") };
        let ours = names(&whole)?.into_iter().map(within).filter(|name| manifest.owns(name));
        for name in ours {
            require_plain(&path.join(&name), false)?;
            found.push(name);
        }
    }
    Ok(found)
}

/// Names in a folder; none if it is not there.
fn names(folder: &Path) -> Result<Vec<String>, SimError> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries,
    };
    let names = entries.and_then(|entries| {
        entries.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned())).collect()
    });
    names.map_err(SimError::io("read the folder", folder))
}

/// What the run in a folder lists; nothing where there is none.
fn read_manifest(folder: &Path) -> Result<Option<Manifest>, SimError> {
    let path = folder.join(MANIFEST);
    require_plain(&path, false)?;
    match fs::read_to_string(&path) {
        Ok(text) => Manifest::parse(&text).map(Some).ok_or(SimError::ForeignFile(path)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(SimError::io("read", &path)(error)),
    }
}

fn write_manifest(folder: &Path, manifest: &Manifest) -> Result<(), SimError> {
    let text = manifest.to_string();
    write_atomically(&folder.join(MANIFEST), |to| to.write_all(text.as_bytes()))
}

#[cfg(test)]
mod tests;
