//! How trees are searched: algorithm 3 of the thesis.

use super::{Hierarchy, SearchResult, VolumeTree};
use crate::capsules::count;
use crate::thesis::volume::BoundingVolume;
use crate::{Capsules, CollisionError, Pair};
use std::any::Any;
use std::ops::ControlFlow;

impl<V: BoundingVolume> Hierarchy for VolumeTree<V> {
    fn update(&mut self, capsules: &Capsules) -> Result<(), CollisionError> {
        self.check(capsules)?;
        self.refit(capsules);
        Ok(())
    }

    fn rebuild(&mut self, capsules: &Capsules) {
        *self = Self::new(self.kind, self.shared.clone(), capsules);
    }

    fn all(&self, capsules: &Capsules) -> Result<SearchResult, CollisionError> {
        self.itself(capsules, false)
    }

    fn first(&self, capsules: &Capsules) -> Result<SearchResult, CollisionError> {
        self.itself(capsules, true)
    }

    fn between(
        &self,
        capsules: &Capsules,
        other: &dyn Hierarchy,
        others: &Capsules,
    ) -> Result<SearchResult, CollisionError> {
        let other = (other as &dyn Any).downcast_ref::<Self>();
        let other = other.filter(|o| o.shared == self.shared).ok_or(CollisionError::Volumes)?;
        self.check(capsules)?;
        other.check(others)?;
        let mut search = DualTraversal::new([self, other], [capsules, others], false);
        // It never breaks off.
        let _ = search.descend([0, 0], Some);
        Ok(search.found)
    }

    fn mean_volumes(&self) -> Vec<f64> {
        let mut levels: Vec<(f64, f64)> = Vec::new();
        let mut pending = vec![(0, 0)];
        while let Some((u, level)) = pending.pop() {
            if levels.len() == level {
                levels.push((0.0, 0.0));
            }
            levels[level].0 += self.volumes[u].volume();
            levels[level].1 += 1.0;
            if !self.is_leaf(u) {
                pending.extend(self.children(u).map(|child| (child, level + 1)));
            }
        }
        levels.into_iter().map(|(sum, nodes)| sum / nodes).collect()
    }
}

impl<V: BoundingVolume> VolumeTree<V> {
    fn check(&self, capsules: &Capsules) -> Result<(), CollisionError> {
        count("segments", capsules.len(), self.order.len())
    }

    /// Pairs within the tree, or only the first.
    ///
    /// A pair of a node with itself is not pushed as a pair of nodes, where it would find all twice
    /// (erratum to algorithm 3), but gives that of its children and theirs with themselves: so each
    /// inner node is a start.
    fn itself(
        &self,
        capsules: &Capsules,
        only_first: bool,
    ) -> Result<SearchResult, CollisionError> {
        self.check(capsules)?;
        let mut search = DualTraversal::new([self, self], [capsules, capsules], only_first);
        // In one order whatever the tree, as roundings depend on it.
        let pair = |[i, j]: Pair| {
            (!capsules.adjacent(i as usize, j as usize)).then_some([i.min(j), i.max(j)])
        };
        for u in (0..self.nodes.len()).filter(|&u| !self.is_leaf(u)) {
            if search.descend(self.children(u), pair).is_break() {
                break;
            }
        }
        Ok(search.found)
    }
}

/// Two trees, perhaps the same, on the way down.
struct DualTraversal<'a, V: BoundingVolume> {
    trees: [&'a VolumeTree<V>; 2],
    capsules: [&'a Capsules<'a>; 2],
    only_first: bool,
    pending: Vec<[usize; 2]>,
    found: SearchResult,
}

impl<'a, V: BoundingVolume> DualTraversal<'a, V> {
    fn new(
        trees: [&'a VolumeTree<V>; 2],
        capsules: [&'a Capsules<'a>; 2],
        only_first: bool,
    ) -> Self {
        Self { trees, capsules, only_first, pending: Vec::new(), found: SearchResult::default() }
    }

    /// Finds the segments under two nodes that touch, of those pairs that `chosen` leaves; breaks
    /// off after the first if that is enough.
    fn descend(
        &mut self,
        start: [usize; 2],
        chosen: impl Fn(Pair) -> Option<Pair>,
    ) -> ControlFlow<()> {
        let [first, second] = self.trees;
        self.pending.push(start);
        while let Some([u, v]) = self.pending.pop() {
            self.found.counts.volume_tests += 1;
            if !first.volumes[u].overlaps(&second.volumes[v]) {
                continue;
            }
            self.found.counts.overlaps += 1;
            let divide_first = match (first.is_leaf(u), second.is_leaf(v)) {
                (true, true) => {
                    if let Some(pair) = chosen([first.segment(u), second.segment(v)]) {
                        self.meet(pair)?;
                    }
                    continue;
                }
                (leaf, other) => other || !leaf && first.nodes[u].weight >= second.nodes[v].weight,
            };
            if divide_first {
                self.pending.extend(first.children(u).map(|child| [child, v]));
            } else {
                self.pending.extend(second.children(v).map(|child| [u, child]));
            }
        }
        ControlFlow::Continue(())
    }

    fn meet(&mut self, [i, j]: Pair) -> ControlFlow<()> {
        let (a, b) = (self.capsules[0].get(i as usize), self.capsules[1].get(j as usize));
        self.found.counts.segment_tests += 1;
        if a.closest(&b).distance() <= a.radius + b.radius {
            self.found.pairs.push([i, j]);
            if self.only_first {
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }
}
