//! All pairs of boxes that meet.

use super::block::{Compare, Portable};
use super::{Level, Tree};
use crate::Pair;
use pulp::{NullaryFnOnce, Simd};

impl Tree {
    /// All pairs of segments, not adjacent, whose boxes meet.
    pub fn pairs(&self, pairs: &mut Vec<Pair>) {
        pairs.clear();
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V4::try_new() {
            let compare = super::block::Masks(simd);
            simd.vectorize(Search { tree: self, compare, pairs });
            return;
        }
        pulp::Arch::new().dispatch(Search { tree: self, compare: Portable, pairs });
    }
}

struct Search<'a, C> {
    tree: &'a Tree,
    compare: C,
    pairs: &'a mut Vec<Pair>,
}

impl<C: Compare> NullaryFnOnce for Search<'_, C> {
    type Output = ();
    #[inline(always)]
    fn call(mut self) {
        self.all();
    }
}

impl<C: Compare> Search<'_, C> {
    #[inline(always)]
    fn all(&mut self) {
        let mut partners = Vec::new();
        for first in 0..self.tree.levels[1].blocks.len() {
            partners.clear();
            self.partners(first, &mut partners);
            for &second in &partners {
                self.groups(first, second as usize);
            }
        }
    }

    /// Blocks of the second level, from `first` on, that meet it.
    #[inline(always)]
    fn partners(&self, first: usize, partners: &mut Vec<u32>) {
        let levels = &self.tree.levels;
        let hull = &levels[1].hulls[first];
        let mut stack = vec![(levels.len() - 1, 0)];
        while let Some((level, block)) = stack.pop() {
            if level == 1 {
                if block as usize >= first {
                    partners.push(block);
                }
                continue;
            }
            let mut meet = self.compare.meet(&levels[level].blocks[block as usize], hull);
            while meet != 0 {
                let lane = meet.trailing_zeros() as usize;
                meet &= meet - 1;
                stack.push((level - 1, levels[level].children[block as usize][lane]));
            }
        }
    }

    #[inline(always)]
    fn groups(&mut self, first: usize, second: usize) {
        let Level { blocks, children, hulls } = &self.tree.levels[1];
        let mut mine = self.compare.meet(&blocks[first], &hulls[second]);
        while mine != 0 {
            let lane = mine.trailing_zeros() as usize;
            mine &= mine - 1;
            let mut theirs = self.compare.meet(&blocks[second], &blocks[first].get(lane));
            if first == second {
                theirs &= u16::MAX << lane;
            }
            let a = children[first][lane] as usize;
            while theirs != 0 {
                let b = children[second][theirs.trailing_zeros() as usize] as usize;
                theirs &= theirs - 1;
                self.blocks(a, b);
            }
        }
    }

    #[inline(always)]
    fn blocks(&mut self, a: usize, b: usize) {
        let lowest = &self.tree.levels[0];
        let (first, second) = (&lowest.blocks[a], &lowest.blocks[b]);
        let mut mine = self.compare.meet(first, &lowest.hulls[b]);
        let theirs = self.compare.meet(second, &lowest.hulls[a]);
        if theirs == 0 {
            return;
        }
        while mine != 0 {
            let lane = mine.trailing_zeros() as usize;
            mine &= mine - 1;
            let mut meet = self.compare.meet(second, &first.get(lane));
            if a == b {
                meet &= (u16::MAX << lane) << 1;
            }
            let node = self.tree.nodes[a][lane];
            let s = lowest.children[a][lane];
            while meet != 0 {
                let other = meet.trailing_zeros() as usize;
                meet &= meet - 1;
                if node.abs_diff(self.tree.nodes[b][other]) > 1 {
                    let t = lowest.children[b][other];
                    self.pairs.push([s.min(t), s.max(t)]);
                }
            }
        }
    }
}
