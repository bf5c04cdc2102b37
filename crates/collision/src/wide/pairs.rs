//! All pairs of boxes that meet.

use super::block::{Compare, PortableCompare};
use super::bounds::Bounds;
use super::{Diagonals, NONE, Tree, TreeLevel};
use crate::Pair;
use crate::join::join;
use pulp::{Arch, NullaryFnOnce};
use rapunzel_lanes::LANES_F32;
use rayon::prelude::*;
use std::ops::Range;

/// Blocks of the second level whose pairs one thread finds at a time.
const TRAVERSAL_CHUNK: usize = 16;

impl Tree {
    /// All pairs of segments, not adjacent, whose boxes meet; `pairs` is emptied first.
    ///
    /// The order depends on the tree alone, not on the number of threads. Cost: 45 ns a segment
    /// where a segment has one partner.
    pub fn pairs(&self, pairs: &mut Vec<Pair>) {
        self.sifted_pairs(|found| found.clone(), pairs);
    }

    /// What `sift` makes of parts of all pairs, in their order: of pairs that nobody wants no list
    /// is ever made.
    pub(super) fn sifted_pairs<T: Copy + Send + Sync>(
        &self,
        sift: impl Fn(&mut Vec<Pair>) -> Vec<T> + Sync + Send,
        all: &mut Vec<T>,
    ) {
        self.sifted(None, sift, all);
    }

    /// The same of the pairs of which a segment is marked.
    pub(super) fn sifted_pairs_of<T: Copy + Send + Sync>(
        &self,
        marked: &[bool],
        sift: impl Fn(&mut Vec<Pair>) -> Vec<T> + Sync + Send,
        all: &mut Vec<T>,
    ) {
        let [lowest, second, ..] = &self.levels[..] else { return };
        let lowest = lowest.with_marked(marked);
        let blocks = [second.with_marked(&lowest), lowest];
        let sift = |pairs: &mut Vec<Pair>| {
            pairs.retain(|pair| pair.iter().any(|&segment| marked[segment as usize]));
            sift(pairs)
        };
        self.sifted(Some(&blocks), sift, all);
    }

    fn sifted<T: Copy + Send + Sync>(
        &self,
        marked: Option<&[Vec<bool>; 2]>,
        sift: impl Fn(&mut Vec<Pair>) -> Vec<T> + Sync + Send,
        all: &mut Vec<T>,
    ) {
        let (levels, diagonals) = (&self.levels, self.diagonals.as_ref());
        let last = levels[1].blocks.len();
        let part = |pairs: &mut Vec<Pair>, chunk: usize| {
            let firsts = chunk * TRAVERSAL_CHUNK..last.min((chunk + 1) * TRAVERSAL_CHUNK);
            search(Query { levels, diagonals, nodes: &self.nodes, firsts, marked }, pairs);
            sift(pairs)
        };
        let chunks = (0..last.div_ceil(TRAVERSAL_CHUNK)).into_par_iter();
        join(chunks.map_init(Vec::new, part).collect(), all);
    }
}

impl TreeLevel {
    /// Which blocks hold something that is marked.
    pub(super) fn with_marked(&self, marked: &[bool]) -> Vec<bool> {
        let holds = |children: &[u32; LANES_F32]| {
            children.iter().any(|&child| child != NONE && marked[child as usize])
        };
        self.children.iter().map(holds).collect()
    }
}

impl Tree {
    /// Whether all pairs of blocks of the second level that meet are `good`, when these blocks have
    /// the boxes `hulls`. Refit the tree before it is searched again.
    pub(super) fn regions_that_meet(
        &mut self,
        hulls: Vec<Bounds>,
        good: impl Fn([usize; 2]) -> bool,
    ) -> bool {
        self.levels[1].hulls = hulls;
        for k in 2..self.levels.len() {
            let (below, above) = self.levels.split_at_mut(k);
            above[0].fit_hulls(&below[k - 1].hulls);
        }
        let mut partners = Vec::new();
        (0..self.levels[1].hulls.len()).all(|first| {
            partners.clear();
            partners_of(PortableCompare, &self.levels, first, &mut partners);
            partners.iter().all(|&second| good([first, second as usize]))
        })
    }
}

/// Asks for the pairs between segments below the blocks `firsts` of the second level and those
/// that come after them.
struct Query<'a> {
    levels: &'a [TreeLevel],
    diagonals: Option<&'a Diagonals>,
    nodes: &'a [[u32; LANES_F32]],
    firsts: Range<usize>,
    /// Blocks of the second level and of the lowest: of pairs at least one must be marked, if any
    /// are.
    marked: Option<&'a [Vec<bool>; 2]>,
}

impl Query<'_> {
    /// Whether pairs between two blocks are asked for: of the second level, or of the lowest.
    #[inline(always)]
    fn wants(&self, lowest: bool, a: usize, b: usize) -> bool {
        self.marked.is_none_or(|marked| {
            let marked = &marked[usize::from(lowest)];
            marked[a] || marked[b]
        })
    }
}

fn search(query: Query, pairs: &mut Vec<Pair>) {
    pairs.clear();
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V4::try_new() {
        return simd.vectorize(PairTraversal { query, compare: super::block::Masks(simd), pairs });
    }
    Arch::new().dispatch(PairTraversal { query, compare: PortableCompare, pairs });
}

struct PairTraversal<'a, C> {
    query: Query<'a>,
    compare: C,
    pairs: &'a mut Vec<Pair>,
}

impl<C: Compare> NullaryFnOnce for PairTraversal<'_, C> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        let mut partners = Vec::new();
        for first in self.query.firsts.clone() {
            partners.clear();
            partners_of(self.compare, self.query.levels, first, &mut partners);
            for &second in &partners {
                if self.query.wants(false, first, second as usize) {
                    self.groups(first, second as usize);
                }
            }
        }
    }
}

impl<C: Compare> PairTraversal<'_, C> {
    /// Pairs between the segments below two blocks of the second level.
    #[inline(always)]
    fn groups(&mut self, first: usize, second: usize) {
        let TreeLevel { blocks, children, hulls } = &self.query.levels[1];
        for lane in lanes(self.compare.meet(&blocks[first], &hulls[second])) {
            let mut theirs = self.compare.meet(&blocks[second], &blocks[first].get(lane));
            if first == second {
                theirs &= u16::MAX << lane;
            }
            for other in lanes(theirs) {
                let (a, b) = (children[first][lane] as usize, children[second][other] as usize);
                if self.query.wants(true, a, b) {
                    self.blocks(a, b);
                }
            }
        }
    }

    /// Pairs between the segments of two blocks of the lowest level.
    #[inline(always)]
    fn blocks(&mut self, a: usize, b: usize) {
        let Self { query, compare, pairs } = self;
        let TreeLevel { blocks, children, hulls } = &query.levels[0];
        let mut theirs = compare.meet(&blocks[b], &hulls[a]);
        if theirs != 0
            && let Some(Diagonals { blocks, hulls }) = query.diagonals
        {
            theirs &= compare.meet(&blocks[b], &hulls[a]);
        }
        if theirs == 0 {
            return;
        }
        let mut mine = compare.meet(&blocks[a], &hulls[b]);
        if mine != 0
            && let Some(Diagonals { blocks, hulls }) = query.diagonals
        {
            mine &= compare.meet(&blocks[a], &hulls[b]);
        }
        let (segments, partners) = (&children[a], &children[b]);
        let (nodes, other_nodes) = (&query.nodes[a], &query.nodes[b]);
        for lane in lanes(mine) {
            let mut meet = theirs & compare.meet(&blocks[b], &blocks[a].get(lane));
            meet &= !compare.adjacent(other_nodes, nodes[lane]);
            if a == b {
                meet &= u16::MAX << lane;
            }
            if meet != 0
                && let Some(Diagonals { blocks, .. }) = query.diagonals
            {
                meet &= compare.meet(&blocks[b], &blocks[a].get(lane));
            }
            let s = segments[lane];
            for other in lanes(meet) {
                let t = partners[other];
                pairs.push([s.min(t), s.max(t)]);
            }
        }
    }
}

/// Blocks of the second level, from `first` on, whose boxes meet that of `first`.
#[inline(always)]
fn partners_of(compare: impl Compare, levels: &[TreeLevel], first: usize, partners: &mut Vec<u32>) {
    let hull = &levels[1].hulls[first];
    let mut stack = vec![(levels.len() - 1, 0)];
    while let Some((level, block)) = stack.pop() {
        if level == 1 {
            if block as usize >= first {
                partners.push(block);
            }
            continue;
        }
        let meet = compare.meet(&levels[level].blocks[block as usize], hull);
        for lane in lanes(meet) {
            stack.push((level - 1, levels[level].children[block as usize][lane]));
        }
    }
}

/// The lanes whose bits are set.
#[inline(always)]
fn lanes(mut bits: u16) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (bits != 0).then(|| {
            let lane = bits.trailing_zeros() as usize % LANES_F32;
            bits &= bits - 1;
            lane
        })
    })
}
