//! A run that was recorded, or is still being written, alone or with another beside it; or
//! something of which there is one frame.

use crate::clock::WallPace;
use crate::extras::{Extras, Shows, boxes, node_pushes};
use crate::frame::{Colors, FrameHead, ShownPoints, frame};
use crate::layout::{Parts, layout};
use nalgebra::{Isometry3, Point3, Translation3, Vector3};
use rapunzel_export::Frame;
use rapunzel_export::surface::Placed;
use rapunzel_sim::{Shown, ShownFrame, ShownStage, SimError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How often is looked for new frames.
const LOOK: Duration = Duration::from_millis(500);
/// Way from a run to the one beside it, over the width of the first frame.
const APART: f64 = 1.3;
/// Size of an object over that of the hair from which on it counts as ground.
const LARGE: f64 = 2.5;

/// Frames with one that is shown.
pub(crate) struct Recorded {
    path: PathBuf,
    shown: Shown,
    pub(crate) index: usize,
    pub(crate) now: ShownFrame,
    second: Option<Second>,
    pub(crate) pace: WallPace,
    looked: Instant,
}

/// The second of two runs.
struct Second {
    path: PathBuf,
    shown: Shown,
    /// Times of its frames, s, as far as they were asked for.
    times: BTreeMap<usize, f64>,
    index: usize,
    now: ShownFrame,
    /// Way by which it is moved aside where it is not over the first, m.
    aside: Vector3<f64>,
    over: bool,
}

impl Recorded {
    /// Opens a run or what else can be shown, and another beside it if there is one.
    pub(crate) fn open(
        path: &Path,
        beside: Option<&Path>,
        at: &dyn Fn(ShownStage),
    ) -> Result<Self, SimError> {
        let shown = Shown::open(path, at)?;
        let (now, looked) = (shown.frame(0)?, Instant::now());
        let second = beside.map(|path| Second::open(path, &now, at)).transpose()?;
        let (path, pace) = (path.to_owned(), WallPace::new());
        Ok(Self { path, shown, index: 0, now, second, pace, looked })
    }

    /// Number of frames.
    pub(crate) fn count(&self) -> usize {
        self.shown.count()
    }

    /// Strands of the first of two runs; none where there is one.
    pub(crate) fn first_of_two(&self) -> Option<usize> {
        self.second.as_ref().map(|_| self.now.frame.strands.len())
    }

    /// Time of the frame of the second of two runs, s, and whether it is over the first.
    pub(crate) fn second(&self) -> Option<(f64, bool)> {
        self.second.as_ref().map(|second| (second.now.frame.time, second.over))
    }

    /// Lays the second of two runs over the first, or beside it.
    pub(crate) fn lay(&mut self, over: bool) {
        self.second.iter_mut().for_each(|second| second.over = over);
    }

    /// Shows a frame; of a number behind the last one that.
    pub(crate) fn seek(&mut self, index: usize) -> Result<(), SimError> {
        let index = index.min(self.count() - 1);
        if index != self.index {
            (self.now, self.index) = (self.shown.frame(index)?, index);
            let time = self.now.frame.time;
            self.second.iter_mut().try_for_each(|second| second.seek(time))?;
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
        if let Some(second) = self.second.as_mut().filter(|second| second.path.is_dir())
            && let Ok(shown) = Shown::open(&second.path, &|_| ())
        {
            second.shown = shown;
        }
        self.count() > before
    }

    /// Strands and objects of the frame, of both runs where there are two.
    fn parts(&self) -> (Frame, Vec<Placed>) {
        let (mut frame, mut objects) = (self.now.frame.clone(), self.now.objects.clone());
        if let Some(second) = &self.second {
            let ShownFrame { frame: other, objects: more } = second.moved();
            frame.strands.extend(other.strands);
            objects.extend(more);
        }
        (frame, objects)
    }

    pub(crate) fn layout(&self, number: u32) -> Vec<u8> {
        let (frame, objects) = self.parts();
        layout(&Parts {
            number,
            strands: &frame.strands,
            prims: &[],
            supports: &[],
            objects: &objects,
            springs: false,
            first_of_two: self.first_of_two(),
        })
    }

    pub(crate) fn frame(&self, layout: u32, colors: &mut Colors, shows: Shows) -> Vec<u8> {
        let (shown, objects) = self.parts();
        let poses: Vec<Isometry3<f64>> = objects.iter().map(|object| object.pose).collect();
        let head = FrameHead { layout, number: self.index as u64, time: self.now.frame.time };
        let mut extras = Extras::default();
        if shows.contacts {
            extras.pushes = node_pushes(&shown.strands);
        }
        if let Some(level) = shows.volumes {
            extras.boxes = boxes(&shown.strands, level);
        }
        let points = ShownPoints::of_strands(&shown.strands, colors.by);
        let mut bytes = frame(head, &points, &poses, colors);
        extras.write(&mut bytes);
        bytes
    }

    /// Strands and objects as a picture shows them, and the ratio of the semi-axes of sections.
    pub(crate) fn picture(&self) -> (Frame, Vec<Placed>, Option<f64>) {
        let (frame, objects) = self.parts();
        (frame, objects, self.shown.ratio())
    }
}

/// Lowest and highest coordinates of points, m.
fn bounds<'a>(points: impl IntoIterator<Item = &'a Point3<f64>>) -> [Vector3<f64>; 2] {
    let none = [f64::MAX, f64::MIN].map(Vector3::repeat);
    let wider = |[low, high]: [Vector3<f64>; 2], point: &Point3<f64>| {
        [low.inf(&point.coords), high.sup(&point.coords)]
    };
    points.into_iter().fold(none, wider)
}

impl Second {
    fn open(path: &Path, first: &ShownFrame, at: &dyn Fn(ShownStage)) -> Result<Self, SimError> {
        let shown = Shown::open(path, at)?;
        let now = shown.frame(0)?;
        let hair = bounds(first.frame.strands.iter().flat_map(|strand| &strand.points));
        let size = hair[1] - hair[0];
        let objects = first.objects.iter().map(|object| bounds(&object.surface.vertices));
        // The ground may lie in that of the other.
        let objects = objects.filter(|[low, high]| (high - low).norm() <= LARGE * size.norm());
        let [low, high] =
            objects.fold(hair, |[low, high], own| [low.inf(&own[0]), high.sup(&own[1])]);
        // A lock that hangs is narrow, and swings.
        let aside = Vector3::x() * (APART * (high.x - low.x).max(0.3 * size.z).max(0.0));
        let (path, times) = (path.to_owned(), BTreeMap::new());
        Ok(Self { path, shown, times, index: 0, now, aside, over: false })
    }

    /// Shows the last frame that is not after a time, s. Reads few frames to find it.
    fn seek(&mut self, time: f64) -> Result<(), SimError> {
        let (mut low, mut high) = (0, self.shown.count() - 1);
        while low < high {
            let middle = (low + high).div_ceil(2);
            if self.time(middle)? <= time * (1.0 + 1e-9) {
                low = middle;
            } else {
                high = middle - 1;
            }
        }
        if low != self.index {
            (self.now, self.index) = (self.shown.frame(low)?, low);
        }
        Ok(())
    }

    /// Time of a frame, s.
    fn time(&mut self, index: usize) -> Result<f64, SimError> {
        if let Some(time) = self.times.get(&index) {
            return Ok(*time);
        }
        let time = self.shown.frame(index)?.frame.time;
        self.times.insert(index, time);
        Ok(time)
    }

    /// The frame where it is shown.
    fn moved(&self) -> ShownFrame {
        let mut moved = self.now.clone();
        if !self.over {
            let points = moved.frame.strands.iter_mut().flat_map(|strand| &mut strand.points);
            points.for_each(|point| *point += self.aside);
            for object in &mut moved.objects {
                object.surface.vertices.iter_mut().for_each(|vertex| *vertex += self.aside);
                object.pose = Translation3::from(self.aside) * object.pose;
            }
        }
        moved
    }
}
