//! Files that are there whole or not at all.

use crate::SimError;
use rapunzel_export::ExportError;
use rapunzel_studio::StudioError;
use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

/// Ends the name of a file that is not whole yet.
pub(crate) const PARTIAL: &str = ".partial";

/// Writes `path` so that at any moment it holds either what it held before or all of the new
/// contents, on the disk: into a temporary file beside it, which then takes its name. A link at
/// `path` is replaced and not followed.
///
/// # Errors
/// [`SimError::Io`]; the temporary file is removed.
pub fn write_atomically(
    path: &Path,
    contents: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), SimError> {
    write(path, contents, true)
}

/// Writes `path` like [`write_atomically`], but does not wait for the disk: a kill leaves the old
/// contents or the new ones, a loss of power before the next [`sync`] may leave neither.
pub(crate) fn replace(
    path: &Path,
    contents: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), SimError> {
    write(path, contents, false)
}

fn write(
    path: &Path,
    contents: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    durably: bool,
) -> Result<(), SimError> {
    let partial = partial(path);
    let write = || {
        let mut file = BufWriter::new(create(&partial)?);
        contents(&mut file)?;
        let file = file.into_inner()?;
        if durably {
            file.sync_all()?;
        }
        fs::rename(&partial, path)?;
        if durably { sync_folder(path) } else { Ok(()) }
    };
    write().map_err(|error| {
        // The first error is the one to report; a leftover is overwritten by the next attempt.
        let _ = fs::remove_file(&partial);
        SimError::io("write", path)(error)
    })
}

/// A new file in the place of what a killed process may have left there, without following links.
fn create(path: &Path) -> io::Result<File> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    File::options().write(true).create_new(true).open(path)
}

/// Renames a file that [`sync`] has brought onto the disk, and waits for that too.
pub(crate) fn rename_durably(from: &Path, to: &Path) -> Result<(), SimError> {
    fs::rename(from, to).and_then(|()| sync_folder(to)).map_err(SimError::io("write", to))
}

/// Waits until all that has been written into the file system of `folder` is on its disk. On
/// systems that cannot be asked for one file system it does nothing: a loss of power can cost a run
/// there.
pub(crate) fn sync(folder: &Path) -> Result<(), SimError> {
    #[cfg(any(target_os = "linux", target_os = "android"))]
    {
        let whole = File::open(folder).and_then(|file| Ok(rustix::fs::syncfs(file)?));
        whole.map_err(SimError::io("write", folder))?;
    }
    Ok(())
}

/// Writes a file of `export` or a picture, which replaces what was there.
pub(crate) fn save<E: Into<StudioError>>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), SimError> {
    let mut refused = None;
    let written = replace(path, |to| match write(to).map_err(Into::into) {
        Ok(()) => Ok(()),
        Err(StudioError::Io(error) | StudioError::Frame(ExportError::Io(error))) => Err(error),
        Err(error) => {
            refused = Some(error);
            Err(io::ErrorKind::InvalidData.into())
        }
    });
    match refused {
        Some(source) => Err(SimError::export(path)(source)),
        None => written,
    }
}

/// Refuses what is neither a plain file nor nothing, above all a link, which would lead elsewhere.
///
/// # Errors
/// [`SimError::NotPlain`] or [`SimError::Io`].
pub(crate) fn require_plain(path: &Path, folder: bool) -> Result<(), SimError> {
    match fs::symlink_metadata(path) {
        Ok(data) if if folder { data.is_dir() } else { data.is_file() } => Ok(()),
        Ok(data) => {
            Err(SimError::NotPlain { path: path.to_owned(), link: data.is_symlink(), folder })
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(SimError::io("look at", path)(error)),
    }
}

/// The temporary file beside `path`.
fn partial(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(PARTIAL);
    path.with_file_name(name)
}

/// Makes the entry of `path` in its folder durable.
fn sync_folder(path: &Path) -> io::Result<()> {
    // Windows cannot open folders, and its renames need no such help.
    match path.parent() {
        Some(folder) if cfg!(unix) => {
            // Of a name by itself the folder is the one where the process is.
            let here = folder.as_os_str().is_empty();
            File::open(if here { Path::new(".") } else { folder })?.sync_all()
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_failed_write_leaves_the_old_file() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.txt");
        write_atomically(&path, |to| to.write_all(b"old")).expect("writes");
        let failed = write_atomically(&path, |to| {
            to.write_all(b"half of the new")?;
            Err(io::Error::from(io::ErrorKind::StorageFull))
        });
        let message = failed.expect_err("the writer failed").to_string();
        assert!(message.contains("free some space"), "{message}");
        assert_eq!(fs::read(&path).expect("still there"), b"old");
        assert_eq!(fs::read_dir(folder.path()).expect("lists").count(), 1, "no leftovers");
    }

    #[cfg(unix)]
    #[test]
    fn links_are_replaced_and_not_followed() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let [path, precious] = ["a.txt", "precious"].map(|name| folder.path().join(name));
        fs::write(&precious, "years of work").expect("writes");
        for planted in [&path, &partial(&path)] {
            std::os::unix::fs::symlink(&precious, planted).expect("links");
            write_atomically(&path, |to| to.write_all(b"new")).expect("writes");
            assert_eq!(fs::read(&precious).expect("still there"), b"years of work");
            assert!(fs::symlink_metadata(&path).expect("there").is_file());
            fs::remove_file(&path).expect("removes");
        }
    }
}
