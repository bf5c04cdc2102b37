//! A run that was recorded, or is still being written; or something of which there is one frame.

use crate::clock::WallPace;
use crate::frame::{Colors, FrameHead, frame};
use crate::layout::{Parts, layout};
use nalgebra::Isometry3;
use rapunzel_sim::{Shown, ShownFrame, SimError};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How often is looked for new frames.
const LOOK: Duration = Duration::from_millis(500);

/// Frames with one that is shown.
pub(crate) struct Recorded {
    path: PathBuf,
    shown: Shown,
    pub(crate) index: usize,
    pub(crate) now: ShownFrame,
    pub(crate) pace: WallPace,
    looked: Instant,
}

impl Recorded {
    /// Opens a run or what else can be shown.
    pub(crate) fn open(path: &Path) -> Result<Self, SimError> {
        let shown = Shown::open(path, &|_| ())?;
        let (now, looked) = (shown.frame(0)?, Instant::now());
        Ok(Self { path: path.to_owned(), shown, index: 0, now, pace: WallPace::new(), looked })
    }

    /// Number of frames.
    pub(crate) fn count(&self) -> usize {
        self.shown.count()
    }

    /// Shows a frame; of a number behind the last one that.
    pub(crate) fn seek(&mut self, index: usize) -> Result<(), SimError> {
        let index = index.min(self.count() - 1);
        if index != self.index {
            (self.now, self.index) = (self.shown.frame(index)?, index);
        }
        Ok(())
    }

    /// Shows the next frame; false if there is none, yet.
    pub(crate) fn advance(&mut self) -> Result<bool, SimError> {
        let is_last = self.index + 1 >= self.count();
        if !is_last {
            self.seek(self.index + 1)?;
        }
        Ok(!is_last)
    }

    /// Looks for frames that have been written since, if it is time to; true if there are.
    pub(crate) fn look(&mut self, now: Instant) -> bool {
        if !self.path.is_dir() || now.saturating_duration_since(self.looked) < LOOK {
            return false;
        }
        self.looked = now;
        let before = self.count();
        if let Ok(shown) = Shown::open(&self.path, &|_| ()) {
            self.shown = shown;
        }
        self.count() > before
    }

    pub(crate) fn layout(&self, number: u32) -> Vec<u8> {
        let (strands, objects) = (&self.now.frame.strands[..], &self.now.objects[..]);
        layout(&Parts { number, strands, prims: &[], supports: &[], objects, springs: false })
    }

    pub(crate) fn frame(&self, layout: u32, colors: &mut Colors) -> Vec<u8> {
        let poses: Vec<Isometry3<f64>> =
            self.now.objects.iter().map(|object| object.pose).collect();
        let head = FrameHead { layout, number: self.index as u64, time: self.now.frame.time };
        frame(head, self.now.frame.strands.iter().cloned(), &poses, colors)
    }
}
