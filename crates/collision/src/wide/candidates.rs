//! Pairs that stay good for a while.

use super::bounds::{Bounds, above, below};
use super::way::{OneWay, SegmentWays, Way};
use super::{NONE, Tree};
use crate::capsules::length;
use crate::narrow::{self, CapsuleContact, squared_distances};
use crate::{Capsules, CollisionError, Pair};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// A tree that has grown this much costlier than it was when new is built anew.
const WORN: f64 = 1.5;
/// Part of the margin by which ends of motions may be apart to have the same pairs.
const LIST_SLACK: f64 = 0.5;
/// The same where all that is swept is searched: each end that is elsewhere costs a search, and
/// what is listed in vain for it as well.
const SWEPT_SLACK: f64 = 0.125;
/// Pairs a segment above which a list is too long, and its margin is halved; where there are not
/// even a quarter of them, it is doubled.
const CROWD: usize = 8;
/// The least part of the margin that was asked for; where a list has twice as many pairs even so,
/// half of it.
const LEAST: f64 = 0.125;
/// Longer motions in a row whose pairs are searched for one by one before a list is tried again.
const PATIENCE: usize = 16;
/// A list is worth to be made where no node goes farther than one of so many parts of its margin.
const SHORT: f64 = 16.0;
/// Parts in which motion is followed, each by one thread at a time.
const PARTS: usize = 16;

/// A list of all pairs that may touch, which is looked up far less often than every step.
///
/// The list is made of all pairs with gaps up to a margin wider than is asked for. It stays
/// complete as long as no two segments have come closer by more than the margin. That is known
/// without looking at pairs: the segments of a region of the tree move nearly alike, so the
/// displacements of a region since the list was made lie in a small box, and only regions that
/// overlap are compared. A bundle that swings as a whole can go far before its list is made anew.
#[derive(Debug, Clone)]
pub struct Candidates {
    reach: f64,
    /// The largest.
    margin: f64,
    list: Option<List>,
}

/// The list and what it was made of.
#[derive(Debug, Clone)]
struct List {
    tree: Tree,
    /// What the tree cost when it was new.
    cost: f64,
    pairs: Vec<Pair>,
    reach: f64,
    /// The margin of the list, and the largest that it may have, m.
    margin: f64,
    most: f64,
    /// Positions when the list was made (world), m.
    positions: Vec<Point3<f64>>,
    /// Boxes of the regions when the list was made.
    hulls: Vec<Bounds>,
    /// Region of every segment: its block of the tree's second level.
    regions: Vec<u32>,
    /// The last motion.
    way: Way,
    /// Workspace: the ways of all segments.
    ways: Vec<OneWay>,
    /// Motions in a row that were too wide for a list.
    wide: usize,
}

/// What an update had to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Update {
    /// The list was still complete.
    Kept,
    /// The tree was fitted and searched.
    Refitted,
    /// The tree was built anew and searched.
    Rebuilt,
}

impl Candidates {
    /// Will list all pairs with gaps of at most `reach`, m, and as a reserve up to `margin`, m,
    /// more, or down to a sixteenth of it where many are near.
    ///
    /// # Errors
    /// [`CollisionError::Length`] if either is negative or not finite.
    pub fn new(reach: f64, margin: f64) -> Result<Self, CollisionError> {
        length("reach", reach)?;
        length("margin", margin)?;
        Ok(Self { reach, margin, list: None })
    }

    /// Makes sure that the list is complete for `capsules`. Their layout and radii must stay the
    /// same from update to update; where the layout changes, make new candidates.
    ///
    /// Cost: 7 ns a segment where the list is kept, 100 ns where it is made anew.
    ///
    /// # Errors
    /// [`CollisionError::Count`] if the number of segments or nodes has changed.
    pub fn update(&mut self, capsules: &Capsules) -> Result<Update, CollisionError> {
        let Some(list) = &mut self.list else {
            self.list = Some(List::new(capsules, self.reach, self.margin)?);
            return Ok(Update::Rebuilt);
        };
        if list.stays_complete([capsules], list.margin)? {
            return Ok(Update::Kept);
        }
        list.renew(capsules)
    }

    /// All pairs, not adjacent, with gaps of at most the reach anywhere on the way from `start` to
    /// `end`, each node on a straight line, and some that stay farther apart; each with the squared
    /// distance of its axes at the start, m². The order does not depend on the number of threads.
    ///
    /// Cost: a distance for each pair of the list, which is made anew where it must; where the
    /// motion is wider than half of its margin, a search of what all segments sweep instead, 0.4 us
    /// a segment in a dense lock. Asked again for a motion from the same start to nearly the same
    /// end, only the travel of what was found is looked at, and a search is made for the segments
    /// of the few that end elsewhere.
    ///
    /// # Errors
    /// As [`Candidates::update`], for either.
    pub fn on_the_way(
        &mut self,
        start: &Capsules,
        end: &Capsules,
    ) -> Result<Vec<(Pair, f64)>, CollisionError> {
        if self.list.is_none() {
            self.update(start)?;
        }
        let Some(list) = &mut self.list else { return Ok(Vec::new()) };
        let mut ways = SegmentWays::new(start, end, std::mem::take(&mut list.ways));
        match list.way.astray(start, end) {
            None => list.set_out(start, end, &mut ways)?,
            Some(astray) if astray.nodes.is_empty() => (),
            Some(astray) => list.way.turn(start, end, &astray, &mut list.tree, self.reach)?,
        }
        let found = list.way.go(&mut ways, self.reach);
        list.ways = ways.into_room();
        Ok(found)
    }

    /// All contacts with gaps of at most the reach, as [`crate::contacts`] finds them.
    ///
    /// # Errors
    /// As [`Candidates::update`], which it calls.
    pub fn contacts(
        &mut self,
        capsules: &Capsules,
        contacts: &mut Vec<CapsuleContact>,
    ) -> Result<Update, CollisionError> {
        let update = self.update(capsules)?;
        if let Some(list) = &self.list {
            narrow::contacts(capsules, &list.pairs, self.reach, contacts)?;
        }
        Ok(update)
    }

    /// All pairs, not adjacent, with gaps of at most the reach, and some with wider ones; empty
    /// before the first update. The order does not depend on the number of threads.
    #[must_use]
    pub fn pairs(&self) -> &[Pair] {
        self.list.as_ref().map_or(&[], |list| &list.pairs)
    }
}

impl List {
    /// The list of all pairs with gaps of at most `reach` and a margin of at most `most`: as large
    /// a one as does not make it long.
    fn new(capsules: &Capsules, reach: f64, most: f64) -> Result<Self, CollisionError> {
        let margin = LEAST * most;
        let tree = Tree::with_diagonals(capsules, 0.5 * (reach + margin))?;
        let mut regions = vec![0; capsules.len()];
        for (region, blocks) in (0..).zip(&tree.levels[1].children) {
            for &block in blocks.iter().filter(|&&block| block != NONE) {
                for &s in tree.levels[0].children[block as usize].iter().filter(|&&s| s != NONE) {
                    regions[s as usize] = region;
                }
            }
        }
        let mut list = Self {
            cost: 0.0,
            tree,
            pairs: Vec::new(),
            reach,
            margin,
            most,
            positions: Vec::new(),
            hulls: Vec::new(),
            regions,
            way: Way::default(),
            ways: Vec::new(),
            wide: 0,
        };
        list.search(capsules);
        while list.is_short() {
            list.margin *= 2.0;
            list.tree.refit(capsules, list.grow())?;
            list.search(capsules);
        }
        while list.is_long() {
            list.margin *= 0.5;
            list.tree.refit(capsules, list.grow())?;
            list.search(capsules);
        }
        list.cost = list.tree.cost();
        Ok(list)
    }

    /// By how much boxes are larger than their segments to all sides, m.
    fn grow(&self) -> f64 {
        0.5 * (self.reach + self.margin)
    }

    /// Whether a larger margin would not make it long.
    fn is_short(&self) -> bool {
        self.margin < self.most && 4 * self.pairs.len() < CROWD * self.regions.len()
    }

    /// Whether a smaller margin would be worth it.
    fn is_long(&self) -> bool {
        let least = LEAST * self.most;
        let crowd = if self.margin > least { CROWD } else { 2 * CROWD };
        self.margin > 0.5 * least && self.pairs.len() > crowd * self.regions.len()
    }

    /// Sets out on a motion with the pairs of the list, or of a new one, if it is complete for it,
    /// or else with what the tree finds.
    fn set_out(
        &mut self,
        start: &Capsules,
        end: &Capsules,
        ways: &mut SegmentWays,
    ) -> Result<(), CollisionError> {
        let both = start.positions().iter().zip(end.positions());
        let longest = both.fold(0.0, |longest: f64, (a, b)| {
            let squared = (b - a).norm_squared();
            if squared > longest { squared } else { longest }
        });
        let is_short = SHORT * longest.sqrt() <= self.margin;
        let try_again = is_short || self.wide.is_multiple_of(PATIENCE);
        let slack = |list: &Self| LIST_SLACK * list.margin;
        let kept = |list: &mut Self| list.stays_complete([start, end], list.margin - slack(list));
        let mut complete = try_again && kept(self)?;
        if try_again && !complete && self.positions != start.positions() {
            self.renew(start)?;
            complete = kept(self)?;
        }
        if complete {
            self.wide = 0;
            let reaches = [self.reach, slack(self)];
            self.way.set_out([start, end], ways, &self.pairs, reaches);
        } else {
            self.wide += 1;
            let reaches = [self.reach, SWEPT_SLACK * self.margin];
            self.way.set_out_among([start, end], ways, &mut self.tree, reaches)?;
        }
        Ok(())
    }

    /// Makes the list anew where the segments are now, with another margin if it was too short or
    /// too long.
    fn renew(&mut self, capsules: &Capsules) -> Result<Update, CollisionError> {
        if self.is_short() {
            self.margin *= 2.0;
        } else if self.is_long() {
            self.margin *= 0.5;
        }
        self.way.leave_tree();
        self.tree.refit(capsules, self.grow())?;
        if self.tree.cost() > WORN * self.cost {
            *self = Self::new(capsules, self.reach, self.most)?;
            return Ok(Update::Rebuilt);
        }
        self.search(capsules);
        Ok(Update::Refitted)
    }

    /// Lists all pairs whose grown boxes meet, but those with gaps of more than reach and margin.
    fn search(&mut self, capsules: &Capsules) {
        let grow = 2.0 * self.grow();
        let close = |pairs: &mut Vec<Pair>| {
            let mut squared = Vec::new();
            squared_distances(capsules, pairs, &mut squared);
            let both = pairs.iter().copied().zip(squared);
            let close = both.filter(|(pair, squared)| {
                let [r, q] = pair.map(|s| capsules.radii()[s as usize]);
                // The fast distances may be off by roundings.
                let far = (r + q + grow) * (1.0 + 1e-6);
                *squared <= far * far
            });
            close.map(|(pair, _)| pair).collect()
        };
        self.tree.sifted_pairs(close, &mut self.pairs);
        self.hulls.clone_from(&self.tree.levels[1].hulls);
        self.positions.clear();
        self.positions.extend_from_slice(capsules.positions());
    }

    /// Whether no two segments of regions that meet have come closer by more than `margin`, m,
    /// in any of some frames or between them.
    fn stays_complete<const N: usize>(
        &mut self,
        frames: [&Capsules; N],
        margin: f64,
    ) -> Result<bool, CollisionError> {
        frames.iter().try_for_each(|frame| self.tree.check(frame))?;
        let motions = self.motions(frames);
        let moved = self.hulls.iter().zip(&motions).map(|(hull, motion)| motion.shift(hull));
        let hulls = moved.collect();
        let closer = |[a, b]: [usize; 2]| motions[a].apart(&motions[b]);
        Ok(self.tree.regions_that_meet(hulls, |regions| closer(regions) <= margin))
    }

    /// How far the segments of every region have moved since the list was made.
    fn motions<const N: usize>(&self, frames: [&Capsules; N]) -> Vec<MotionBounds> {
        let layout = frames[0].layout();
        let none = vec![MotionBounds::NONE; self.hulls.len()];
        let length = layout.fibers().div_ceil(PARTS);
        let part = |part: usize| {
            let mut motions = none.clone();
            let fibers = part * length..layout.fibers().min((part + 1) * length);
            for (fiber, frame) in fibers.flat_map(|fiber| frames.map(|frame| (fiber, frame))) {
                let nodes = layout.node_range(fiber);
                let moved = |node: usize| frame.positions()[node] - self.positions[node];
                let mut start = moved(nodes.start);
                for (node, segment) in (nodes.start + 1..nodes.end).zip(layout.segment_range(fiber))
                {
                    let end = moved(node);
                    let motion = &mut motions[self.regions[segment] as usize];
                    motion.hold(&start, &start);
                    motion.hold(&end, &end);
                    start = end;
                }
            }
            motions
        };
        let parts: Vec<_> = (0..PARTS).into_par_iter().map(part).collect();
        let mut motions = none;
        for part in &parts {
            for (motion, other) in motions.iter_mut().zip(part) {
                motion.hold(&other.low, &other.high);
            }
        }
        motions
    }
}

/// Bounds of displacements (world), m.
#[derive(Debug, Clone, Copy)]
struct MotionBounds {
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl MotionBounds {
    const NONE: Self = Self {
        low: Vector3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Vector3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    #[inline(always)]
    fn hold(&mut self, low: &Vector3<f64>, high: &Vector3<f64>) {
        for d in 0..3 {
            self.low[d] = if low[d] < self.low[d] { low[d] } else { self.low[d] };
            self.high[d] = if high[d] > self.high[d] { high[d] } else { self.high[d] };
        }
    }

    /// Where a box may be after the motion.
    fn shift(&self, hull: &Bounds) -> Bounds {
        let mut moved = *hull;
        for d in 0..3 {
            moved.low[d] = below(f64::from(hull.low[d]) + self.low[d]);
            moved.high[d] = above(f64::from(hull.high[d]) + self.high[d]);
        }
        moved
    }

    /// The largest difference of two displacements, m.
    fn apart(&self, other: &Self) -> f64 {
        (self.high - other.low).sup(&(other.high - self.low)).norm()
    }
}
