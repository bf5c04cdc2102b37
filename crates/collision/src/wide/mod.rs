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

use block::Block;
use bounds::{Bounds, nearest};
use rapunzel_lanes::LANES_F32;

/// A tree of boxes over all segments, which finds the pairs whose boxes meet.
///
/// Boxes are in single precision and rounded outward: no pair is missed, and hardly one is found
/// in excess.
#[derive(Debug, Clone)]
pub struct Tree {
    /// Number of segments and of nodes.
    segments: usize,
    node_count: usize,
    /// The blocks of every level, those of segments first, one block last.
    levels: Vec<TreeLevel>,
    diagonals: Option<Diagonals>,
    /// First node of the segment of every lane of the lowest level. Two segments are adjacent or
    /// one if these differ by at most one, because fibres share no node.
    nodes: Vec<[u32; LANES_F32]>,
}

#[derive(Debug, Clone)]
struct TreeLevel {
    blocks: Vec<Block>,
    /// What the box of every lane holds: a segment, or a block of the level below.
    children: Vec<[u32; LANES_F32]>,
    /// Box of every block.
    hulls: Vec<Bounds>,
}

/// What the blocks of the lowest level hold along the diagonals of the axes' planes. Segments are
/// long and thin: of pairs in a lock whose boxes meet two in three do not meet here. That pays
/// where most pairs that are found will be sifted.
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
        Self::grown(capsules, margin, false)
    }

    /// The same, of pairs that meet along the diagonals of the axes' planes, too. It takes twice as
    /// long to fit.
    pub(super) fn with_diagonals(capsules: &Capsules, margin: f64) -> Result<Self, CollisionError> {
        Self::grown(capsules, margin, true)
    }

    fn grown(capsules: &Capsules, margin: f64, oblique: bool) -> Result<Self, CollisionError> {
        length("margin", margin)?;
        let mut lowest = TreeLevel::new(&rough_boxes(capsules));
        let layout = capsules.layout();
        let first_node = |&segment: &u32| match segment {
            NONE => NONE,
            s => u32::try_from(layout.segment_nodes(s as usize)[0]).unwrap_or(NONE),
        };
        let first_nodes = |lanes: &[u32; LANES_F32]| lanes.each_ref().map(first_node);
        let nodes: Vec<_> = lowest.children.iter().map(first_nodes).collect();
        let count = lowest.blocks.len();
        let mut diagonals = oblique.then(|| Diagonals {
            blocks: vec![Block::EMPTY; count],
            hulls: vec![Bounds::EMPTY; count],
        });
        lowest.fit_segments(diagonals.as_mut(), &nodes, [capsules], margin, &vec![true; count]);
        let mut levels = vec![lowest];
        while levels.len() < 2 || levels[levels.len() - 1].blocks.len() > 1 {
            let hulls = &levels[levels.len() - 1].hulls;
            let mut level = TreeLevel::new(hulls);
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
        self.fit([capsules], margin, &vec![true; self.nodes.len()])
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
        self.fit([start, end], margin, &vec![true; self.nodes.len()])
    }

    /// The same where of all segments only those that are marked sweep something else than when the
    /// boxes were fitted last, with the same margin.
    pub(super) fn refit_swept_of(
        &mut self,
        marked: &[bool],
        start: &Capsules,
        end: &Capsules,
        margin: f64,
    ) -> Result<(), CollisionError> {
        let wanted = self.levels[0].with_marked(marked);
        self.fit([start, end], margin, &wanted)
    }

    /// Fits the boxes of those blocks of the lowest level that are `wanted`, and all around them.
    fn fit<const N: usize>(
        &mut self,
        frames: [&Capsules; N],
        margin: f64,
        wanted: &[bool],
    ) -> Result<(), CollisionError> {
        length("margin", margin)?;
        frames.iter().try_for_each(|frame| self.check(frame))?;
        let (lowest, diagonals) = (&mut self.levels[0], self.diagonals.as_mut());
        lowest.fit_segments(diagonals, &self.nodes, frames, margin, wanted);
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

impl TreeLevel {
    /// Groups `boxes`; the blocks are still empty.
    fn new(boxes: &[Bounds]) -> Self {
        let build::Groups { order, ends } = build::group(boxes);
        let mut start = 0;
        let group = |end: usize| {
            let mut lanes = [NONE; LANES_F32];
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

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;
    use proptest::prelude::*;
    use rapunzel_fiber::Layout;

    fn points() -> impl Strategy<Value = Vec<Point3<f64>>> {
        let x = prop_oneof![(-2..=2_i8).prop_map(f64::from), -2.0..2.0_f64];
        prop::collection::vec(prop::array::uniform3(x).prop_map(Point3::from), 40..160)
    }

    proptest! {
        /// Along diagonals some pairs are left out, but none that touches, also where nodes move.
        #[test]
        fn diagonals_leave_what_touches(points in points(), shift in -1.0..1.0_f64) {
            let count = points.len() / 2;
            let (layout, radii) = (Layout::new(std::iter::repeat_n(1, count)), vec![0.1; count]);
            let moved: Vec<_> = points.iter().map(|p| Point3::from(p.coords + shift * p.coords.yzx())).collect();
            let at = |points| Capsules::new(&layout, points, &radii).expect("valid");
            let (start, end) = (at(&points[..2 * count]), at(&moved[..2 * count]));
            let of = |mut tree: Tree| {
                tree.refit_swept(&start, &end, 0.0).expect("the same segments");
                let mut pairs = Vec::new();
                tree.pairs(&mut pairs);
                pairs.sort_unstable();
                pairs
            };
            let all = of(Tree::new(&start, 0.0).expect("valid"));
            let left = of(Tree::with_diagonals(&start, 0.0).expect("valid"));
            prop_assert!(left.iter().all(|pair| all.binary_search(pair).is_ok()));
            let touch = |capsules: &Capsules, &[i, j]: &[u32; 2]| {
                let [a, b] = [i, j].map(|segment| capsules.get(segment as usize));
                a.closest(&b).distance() <= a.radius + b.radius
            };
            for pair in all.iter().filter(|pair| touch(&start, pair) || touch(&end, pair)) {
                prop_assert!(left.binary_search(pair).is_ok(), "{:?}", pair);
            }
        }
    }

    /// Two diagonal segments beside each other share a box, but nothing along the other diagonal.
    #[test]
    fn diagonals_tell_what_boxes_do_not() {
        let points =
            [[0.0; 3], [1.0, 1.0, 0.0], [0.5, 0.0, 0.0], [1.0, 0.5, 0.0]].map(Point3::from);
        let (layout, radii) = (Layout::new([1, 1]), [0.1; 2]);
        let capsules = Capsules::new(&layout, &points, &radii).expect("valid");
        let count = |tree: Result<Tree, CollisionError>| {
            let mut pairs = Vec::new();
            tree.expect("valid").pairs(&mut pairs);
            pairs.len()
        };
        assert_eq!(count(Tree::new(&capsules, 0.0)), 1);
        assert_eq!(count(Tree::with_diagonals(&capsules, 0.0)), 0);
        assert_eq!(count(Tree::with_diagonals(&capsules, 0.1)), 1);
    }
}
