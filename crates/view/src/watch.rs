//! Files that change while they are shown.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// How often is looked at a file.
const LOOK: Duration = Duration::from_millis(500);

/// A file that is watched.
#[derive(Debug)]
pub(crate) struct Watch {
    path: PathBuf,
    /// Time and length of its last change.
    seen: Option<(SystemTime, u64)>,
    looked: Instant,
}

impl Watch {
    pub(crate) fn new(path: &Path) -> Self {
        Self { path: path.to_owned(), seen: stamp(path), looked: Instant::now() }
    }

    /// Whether the file has changed since the last look, if it is time to look.
    pub(crate) fn has_changed(&mut self, now: Instant) -> bool {
        if now.saturating_duration_since(self.looked) < LOOK {
            return false;
        }
        self.looked = now;
        let stamp = stamp(&self.path);
        // A file that is being replaced may be away for a moment.
        let changed = stamp.is_some() && stamp != self.seen;
        self.seen = stamp.or(self.seen);
        changed
    }
}

fn stamp(path: &Path) -> Option<(SystemTime, u64)> {
    let data = fs::metadata(path).ok()?;
    Some((data.modified().ok()?, data.len()))
}
