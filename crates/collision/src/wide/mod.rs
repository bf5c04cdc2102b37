//! The tree for production: sixteen boxes in single precision at a time.
//!
//! Blocks of sixteen boxes are compared with one box in six instructions, where the machine has
//! registers that wide. A tree of four or five levels of blocks holds 100,000 segments; it is built
//! of groups that lie together ([`build`]), fitted to moved segments ([`refit`]) and searched block
//! by block ([`pairs`]). [`Candidates`] keep what a search found for as long as it is complete.

mod block;
mod bounds;
mod build;
mod candidates;
mod lines;
mod pairs;
mod refit;
mod way;

use crate::capsules::{count, length};
use crate::{Capsules, CollisionError};
pub use candidates::{Candidates, Update};

use block::{Block, WIDTH};
use bounds::{Bounds, nearest};

/// A tree of boxes over all segments, which finds the pairs whose boxes meet, and whose extents along the
/// diagonals of the axes' planes do.
///
/// Bounds are in single precision and rounded outward: no pair is missed, and hardly one is found
/// in excess.
#[derive(Debug, Clone)]
pub struct Tree {
    /// Number of segments and of nodes.
    segments: usize,
    node_count: usize,
    /// The blocks of every level, those of segments first, one block last.
    levels: Vec<Level>,
    diagonals: Diagonals,
    /// First node of the segment of every lane of the lowest level. Two segments are adjacent or
    /// one if these differ by at most one, because fibres share no node.
    nodes: Vec<[u32; WIDTH]>,
}

#[derive(Debug, Clone)]
struct Level {
    blocks: Vec<Block>,
    /// What the box of every lane holds: a segment, or a block of the level below.
    children: Vec<[u32; WIDTH]>,
    /// Box of every block.
    hulls: Vec<Bounds>,
}

/// What the blocks of the lowest level hold along the diagonals of the axes' planes. Segments are long and
/// thin: of pairs in a lock whose boxes meet two in three do not meet here.
#[derive(Debug, Clone)]
struct Diagonals {
    blocks: Vec<Block<6>>,
    /// Around every block.
    hulls: Vec<Bounds<6>>,
}

/// A lane without a child.
const NONE: u32 = u32::MAX;

impl Tree {
    /// Builds the tree over boxes grown by `margin`, m, on all sides. Cost: 80 ns a segment.
    ///
    /// # Errors
    /// [`CollisionError::Length`] if the margin is negative or not finite.
    pub fn new(capsules: &Capsules, margin: f64) -> Result<Self, CollisionError> {
        length("margin", margin)?;
        let mut lowest = Level::new(&rough_boxes(capsules));
        let layout = capsules.layout();
        let first_node = |&segment: &u32| match segment {
            NONE => NONE,
            s => u32::try_from(layout.segment_nodes(s as usize)[0]).unwrap_or(NONE),
        };
        let first_nodes = |lanes: &[u32; WIDTH]| lanes.each_ref().map(first_node);
        let nodes: Vec<_> = lowest.children.iter().map(first_nodes).collect();
        let count = lowest.blocks.len();
        let mut diagonals =
            Diagonals { blocks: vec![Block::EMPTY; count], hulls: vec![Bounds::EMPTY; count] };
        lowest.fit_segments(&mut diagonals, &nodes, [capsules], margin);
        let mut levels = vec![lowest];
        while levels.len() < 2 || levels[levels.len() - 1].blocks.len() > 1 {
            let hulls = &levels[levels.len() - 1].hulls;
            let mut level = Level::new(hulls);
            level.fit_hulls(hulls);
            levels.push(level);
        }
        let (segments, node_count) = (layout.segments(), layout.nodes());
        Ok(Self { segments, node_count, levels, diagonals, nodes })
    }

    /// Fits the boxes, grown by `margin`, m, to segments that have moved. Cost: 11 ns a segment.
    ///
    /// # Errors
    /// [`CollisionError::Count`] if there are more or fewer segments or nodes than the tree was
    /// built for, [`CollisionError::Length`] if the margin is negative or not finite.
    pub fn refit(&mut self, capsules: &Capsules, margin: f64) -> Result<(), CollisionError> {
        self.fit([capsules], margin)
    }

    /// Fits the boxes, grown by `margin`, m, to all that segments sweep from `start` to `end`, each
    /// node on a straight line; the radii are those at the start. Cost: 15 ns a segment.
    ///
    /// # Errors
    /// As [`Tree::refit`], for either.
    pub fn refit_swept(
        &mut self,
        start: &Capsules,
        end: &Capsules,
        margin: f64,
    ) -> Result<(), CollisionError> {
        self.fit([start, end], margin)
    }

    fn fit<const N: usize>(
        &mut self,
        frames: [&Capsules; N],
        margin: f64,
    ) -> Result<(), CollisionError> {
        length("margin", margin)?;
        frames.iter().try_for_each(|frame| self.check(frame))?;
        self.levels[0].fit_segments(&mut self.diagonals, &self.nodes, frames, margin);
        for k in 1..self.levels.len() {
            let (below, above) = self.levels.split_at_mut(k);
            above[0].fit_hulls(&below[k - 1].hulls);
        }
        Ok(())
    }

    /// Whether the tree was built for as many segments and nodes.
    fn check(&self, capsules: &Capsules) -> Result<(), CollisionError> {
        let layout = capsules.layout();
        count("segments", layout.segments(), self.segments)?;
        count("nodes", layout.nodes(), self.node_count)
    }

    /// Sum of the surfaces of all boxes that hold others, m²: what a search costs grows with it.
    #[must_use]
    pub fn cost(&self) -> f64 {
        self.levels.iter().flat_map(|level| &level.hulls).map(|hull| f64::from(hull.area())).sum()
    }
}

/// Boxes of the axes of all segments, rounded anyhow: good enough to group them.
fn rough_boxes(capsules: &Capsules) -> Vec<Bounds> {
    let bounds = |segment| {
        let [a, b] = capsules.layout().segment_nodes(segment);
        let (p, q) = (&capsules.positions()[a], &capsules.positions()[b]);
        let mut bounds = Bounds::EMPTY;
        for d in 0..3 {
            bounds.low[d] = nearest(p[d].min(q[d]));
            bounds.high[d] = nearest(p[d].max(q[d]));
        }
        bounds
    };
    (0..capsules.len()).map(bounds).collect()
}

impl Level {
    /// Groups `boxes`; the blocks are still empty.
    fn new(boxes: &[Bounds]) -> Self {
        let build::Groups { order, ends } = build::group(boxes);
        let mut start = 0;
        let group = |end: usize| {
            let mut lanes = [NONE; WIDTH];
            lanes[..end - start].copy_from_slice(&order[start..end]);
            start = end;
            lanes
        };
        let children: Vec<_> = ends.into_iter().map(group).collect();
        let blocks = vec![Block::EMPTY; children.len()];
        let hulls = vec![Bounds::EMPTY; children.len()];
        Self { blocks, children, hulls }
    }
}
