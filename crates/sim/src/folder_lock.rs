//! The lock by which one process alone holds the folder of a run.

use crate::SimError;
use crate::storage::require_plain;
use std::fs::{File, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::Path;

/// The file that is locked.
pub(crate) const LOCK: &str = ".lock";

/// Takes the lock of a folder and writes this process's number into it.
pub(crate) fn lock(folder: &Path) -> Result<File, SimError> {
    let path = folder.join(LOCK);
    require_plain(&path, false)?;
    let mut file = File::options()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .open(&path)
        .map_err(SimError::io("write", &path))?;
    let mut process = String::new();
    // The holder may be about to write its number; what is no number is not from here.
    let read = Read::by_ref(&mut file).take(64).read_to_string(&mut process);
    let process = process.trim().to_owned();
    let is_ours = read.is_ok() && process.bytes().all(|byte| byte.is_ascii_digit());
    match file.try_lock() {
        Ok(()) if is_ours => {}
        Ok(()) => return Err(SimError::ForeignFile(path)),
        Err(TryLockError::WouldBlock) => {
            return Err(SimError::FolderInUse { path: folder.to_owned(), process });
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
