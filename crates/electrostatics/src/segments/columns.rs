//! Segments as sources, a register of them at a time.

use super::lines::{Loads, SegmentLines};
use rapunzel_lanes::{LANES_F32, Real};
use std::ops::Range;

/// Values of a segment that fills a block: far from all others, of unit length and without charge.
const NOTHING: [f64; 9] = [1e9, 1e9, 1e9, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0];

/// Rows of numbers of as many segments as the widest register has lanes.
pub(super) type ColumnBlock<E, const ROWS: usize> = [[E; LANES_F32]; ROWS];

/// Segments as sources, with places from a center.
pub(super) struct SegmentColumns<E> {
    /// Center (world), m.
    pub(super) center: [f64; 3],
    /// Rows of [`SegmentLines::bars`], with middles from the center.
    pub(super) blocks: Vec<ColumnBlock<E, 9>>,
    /// Index of each segment in the order of the tree, `usize::MAX` for what fills a block.
    pub(super) indices: Vec<usize>,
    /// Number of the blocks of segments that act on the targets and feel nothing, which come first.
    pub(super) alone: usize,
    /// Forces and moments that the other blocks feel, doubled, over Coulomb's constant.
    pub(super) felt: Vec<ColumnBlock<E, 6>>,
}

impl<E: Real> SegmentColumns<E> {
    /// Sources of two `parts` of segments: those that act on the targets only, and those that also
    /// feel them.
    pub(super) fn new(lines: &SegmentLines, center: [f64; 3], parts: [&[Range<usize>]; 2]) -> Self {
        let blocks =
            |part: &[Range<usize>]| part.iter().map(Range::len).sum::<usize>().div_ceil(LANES_F32);
        let [alone, mutual] = parts.map(blocks);
        let mut columns = Self {
            center,
            blocks: vec![NOTHING.map(|x| [E::from_f64(x); LANES_F32]); alone + mutual],
            indices: vec![usize::MAX; LANES_F32 * (alone + mutual)],
            alone,
            felt: vec![[[E::from_f64(0.0); LANES_F32]; 6]; mutual],
        };
        for (part, first) in parts.into_iter().zip([0, LANES_F32 * alone]) {
            let mut place = first;
            for range in part {
                columns.fill(lines, place, range.clone());
                place += range.len();
            }
        }
        columns
    }

    /// Puts the segments `range` into the lanes from `place` on.
    fn fill(&mut self, lines: &SegmentLines, mut place: usize, mut range: Range<usize>) {
        while !range.is_empty() {
            let lane = place % LANES_F32;
            let count = range.len().min(LANES_F32 - lane);
            let now = range.start..range.start + count;
            for (k, row) in self.blocks[place / LANES_F32].iter_mut().enumerate() {
                let origin = self.center.get(k).copied().unwrap_or(0.0);
                for (to, x) in row[lane..].iter_mut().zip(&lines.bars[k][now.clone()]) {
                    *to = E::from_f64(x - origin);
                }
            }
            self.indices[place..].iter_mut().zip(now).for_each(|(to, i)| *to = i);
            place += count;
            range.start += count;
        }
    }

    /// Indices of the segments that feel the targets, and their loads.
    pub(super) fn felt(&self) -> impl Iterator<Item = (usize, Loads)> {
        let loads = move |k: usize| {
            let felt = |row: usize| 0.5 * self.felt[k / LANES_F32][row][k % LANES_F32].to_f64();
            let mut loads = [0.0; 7];
            for c in 0..3 {
                loads[1 + c] = felt(3 + c) - felt(c);
                loads[4 + c] = -felt(3 + c) - felt(c);
            }
            loads
        };
        let mutual = self.indices[LANES_F32 * self.alone..].iter().enumerate();
        mutual.filter(|(_, i)| **i < usize::MAX).map(move |(k, i)| (*i, loads(k)))
    }
}
