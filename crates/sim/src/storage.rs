//! Files that are there whole or not at all.

use crate::SimError;
use crate::export::ExportError;
use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

/// Ends the name of a file that is not whole yet.
pub(crate) const PARTIAL: &str = ".partial";

/// Writes `path` so that at any moment it holds either what it held before or all of the new
/// contents, on the disk: into a temporary file beside it, which then takes its name.
///
/// # Errors
/// [`SimError::Io`]; the temporary file is removed.
pub fn write_atomically(
    path: &Path,
    contents: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), SimError> {
    prepare(path, contents)?;
    put_in_place(path)
}

/// Writes the next contents of `path` into the temporary file beside it, where they wait for
/// [`put_in_place`].
pub(crate) fn prepare(
    path: &Path,
    contents: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), SimError> {
    let write = || {
        let mut file = BufWriter::new(File::create(partial(path))?);
        contents(&mut file)?;
        file.into_inner()?;
        Ok(())
    };
    write().map_err(|error| given_up(path, error))
}

/// Puts what has been prepared in the place of what `path` held, once it is on the disk.
pub(crate) fn put_in_place(path: &Path) -> Result<(), SimError> {
    let partial = partial(path);
    let put = || {
        File::options().write(true).open(&partial)?.sync_all()?;
        fs::rename(&partial, path)?;
        sync_folder(path)
    };
    put().map_err(|error| given_up(path, error))
}

fn given_up(path: &Path, error: io::Error) -> SimError {
    // The first error is the one to report; a leftover is overwritten by the next attempt.
    let _ = fs::remove_file(partial(path));
    SimError::io("write", path)(error)
}

/// Writes a file of `export` atomically.
pub(crate) fn save(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), ExportError>,
) -> Result<(), SimError> {
    let mut refused = None;
    let written = write_atomically(path, |to| match write(to) {
        Ok(()) => Ok(()),
        Err(ExportError::Io(error)) => Err(error),
        Err(error) => {
            refused = Some(error);
            Err(io::ErrorKind::InvalidData.into())
        }
    });
    match refused {
        Some(source) => Err(SimError::Export { path: path.to_owned(), source }),
        None => written,
    }
}

/// The temporary file beside `path`.
pub(crate) fn partial(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(PARTIAL);
    path.with_file_name(name)
}

/// Makes the entry of `path` in its folder durable.
fn sync_folder(path: &Path) -> io::Result<()> {
    // Windows cannot open folders, and its renames need no such help.
    match path.parent() {
        Some(folder) if cfg!(unix) => File::open(folder)?.sync_all(),
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
}
