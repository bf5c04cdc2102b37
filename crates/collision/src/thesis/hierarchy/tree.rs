//! How trees are built and kept.

use super::spatial;
use crate::thesis::volume::BoundingVolume;
use crate::{Capsule, Capsules};
use rapunzel_fiber::Layout;

/// Which segments come together in a node, and what its volume encloses (thesis, 7.3.3).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HierarchyKind {
    /// `H_R`: segments that are near each other, divided from the top at the middle of the longest
    /// axis. Volumes enclose segments when built, and the volumes below when updated.
    Spatial,
    /// `H_TD`: segments that follow each other, halved from the top. Volumes enclose segments, and
    /// the few that determine them are kept (combinatorial bases).
    Wrapped,
    /// `H_TI`: segments that follow each other; volumes enclose the two below.
    Layered,
}

/// A binary tree of volumes of one type with a segment at each leaf.
///
/// The topological kinds thread all fibers into one: every second fiber is passed from the tip to
/// the root, so that ends of neighbors follow each other (figure 7.4 of the thesis).
#[derive(Debug, Clone)]
pub struct VolumeTree<V: BoundingVolume> {
    pub(super) kind: HierarchyKind,
    pub(super) shared: V::Shared,
    /// Segments in the order of the leaves.
    pub(super) order: Vec<u32>,
    /// A node, all nodes under its left child, all nodes under its right child, and so on.
    pub(super) nodes: Vec<HierarchyNode>,
    pub(super) volumes: Vec<V>,
    /// Of the inner nodes of wrapped trees: the segments that determine the volume.
    bases: Vec<Vec<u32>>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct HierarchyNode {
    /// Its leaves in `order`, from the first.
    pub(super) first: usize,
    pub(super) leaves: usize,
    /// Of two nodes the one with more weight is divided: volume in spatial trees, number of leaves
    /// in topological ones.
    pub(super) weight: f64,
}

impl<V: BoundingVolume> VolumeTree<V> {
    /// Builds a tree over all segments. Cost: as of [`super::Hierarchy::rebuild`].
    #[must_use]
    pub fn new(kind: HierarchyKind, shared: V::Shared, capsules: &Capsules) -> Self {
        let order = thread(capsules.layout());
        let most = 2 * order.len() - 1;
        let (nodes, volumes) = (Vec::with_capacity(most), Vec::with_capacity(most));
        let mut tree = Self { kind, shared, order, nodes, volumes, bases: Vec::new() };
        match kind {
            HierarchyKind::Spatial => tree.divide(capsules),
            HierarchyKind::Wrapped => {
                tree.halve();
                for u in 0..tree.nodes.len() {
                    let (volume, basis) = tree.span(u, capsules);
                    tree.volumes.push(volume);
                    tree.bases.push(basis);
                }
            }
            HierarchyKind::Layered => {
                tree.halve();
                tree.layer(capsules);
            }
        }
        tree
    }

    /// The volume of every node.
    #[must_use]
    pub fn volumes(&self) -> &[V] {
        &self.volumes
    }

    /// The segments under every node, nodes as in [`Self::volumes`].
    pub fn segments(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.nodes.len()).map(|u| self.under(u))
    }

    pub(super) fn children(&self, u: usize) -> [usize; 2] {
        [u + 1, u + 2 * self.nodes[u + 1].leaves]
    }

    pub(super) fn is_leaf(&self, u: usize) -> bool {
        self.nodes[u].leaves == 1
    }

    pub(super) fn segment(&self, leaf: usize) -> u32 {
        self.order[self.nodes[leaf].first]
    }

    fn under(&self, u: usize) -> &[u32] {
        let HierarchyNode { first, leaves, .. } = self.nodes[u];
        &self.order[first..][..leaves]
    }

    /// Makes the nodes of a topological tree: halves down to single leaves.
    fn halve(&mut self) {
        let mut pending = vec![(0, self.order.len())];
        while let Some((first, leaves)) = pending.pop() {
            self.nodes.push(HierarchyNode { first, leaves, weight: leaves as f64 });
            if leaves > 1 {
                let left = leaves.div_ceil(2);
                pending.push((first + left, leaves - left));
                pending.push((first, left));
            }
        }
    }

    /// Makes the nodes and volumes of a spatial tree from the top, and with them the order.
    fn divide(&mut self, capsules: &Capsules) {
        let mut pending = vec![(0, self.order.len())];
        while let Some((first, leaves)) = pending.pop() {
            let segments = &mut self.order[first..][..leaves];
            let volume = if leaves == 1 {
                V::of_capsule(&self.shared, &capsules.get(segments[0] as usize))
            } else {
                V::wrap(&self.shared, chosen(segments, capsules))
            };
            if leaves > 1 {
                let axes = volume.axes(&self.shared, chosen(segments, capsules));
                let left = spatial::divide(segments, &axes, capsules);
                pending.push((first + left, leaves - left));
                pending.push((first, left));
            }
            self.nodes.push(HierarchyNode { first, leaves, weight: volume.volume() });
            self.volumes.push(volume);
        }
    }

    /// Makes the volumes of a layered tree from the leaves up.
    fn layer(&mut self, capsules: &Capsules) {
        // Backward, every node comes after those below it.
        let last = self.nodes.len() - 1;
        for u in (0..=last).rev() {
            let below = |v: usize| &self.volumes[last - v];
            let volume = self.merged(u, below, capsules);
            self.volumes.push(volume);
        }
        self.volumes.reverse();
    }

    /// The volume of a node around those right below it.
    fn merged<'a>(&self, u: usize, volume: impl Fn(usize) -> &'a V, capsules: &Capsules) -> V {
        let capsule = |&segment: &u32| capsules.get(segment as usize);
        match self.under(u) {
            [segment] => V::of_capsule(&self.shared, &capsule(segment)),
            [first, second] => V::of_pair(&self.shared, &capsule(first), &capsule(second)),
            _ => {
                let [l, r] = self.children(u);
                volume(l).merge(volume(r))
            }
        }
    }

    /// The volume of a node around its segments, and the segments of its basis.
    fn span(&self, u: usize, capsules: &Capsules) -> (V, Vec<u32>) {
        let segments = self.under(u);
        if let [segment] = segments {
            let volume = V::of_capsule(&self.shared, &capsules.get(*segment as usize));
            return (volume, Vec::new());
        }
        let (volume, places) = V::span(&self.shared, chosen(segments, capsules));
        (volume, places.into_iter().map(|place| segments[place as usize]).collect())
    }

    /// Encloses moved capsules: algorithm 5. Backward through the nodes is an order in which all
    /// that is below a node is done before.
    pub(super) fn refit(&mut self, capsules: &Capsules) {
        for u in (0..self.nodes.len()).rev() {
            let (volume, basis) = match self.kind {
                HierarchyKind::Wrapped => self.verified(u, capsules),
                HierarchyKind::Spatial | HierarchyKind::Layered => {
                    (self.merged(u, |v| &self.volumes[v], capsules), None)
                }
            };
            if self.kind == HierarchyKind::Spatial {
                self.nodes[u].weight = volume.volume();
            }
            if let Some(basis) = basis {
                self.bases[u] = basis;
            }
            self.volumes[u] = volume;
        }
    }

    /// The volume of a wrapped node, and its basis if that has changed: the cascade verification of
    /// algorithm 4. All below `u` is up to date.
    fn verified(&self, u: usize, capsules: &Capsules) -> (V, Option<Vec<u32>>) {
        if self.is_leaf(u) {
            return (self.span(u, capsules).0, None);
        }
        let old = &self.volumes[u];
        let candidate = old.respan(&self.shared, chosen(&self.bases[u], capsules));
        let mut pending = self.children(u).to_vec();
        while let Some(v) = pending.pop() {
            if !candidate.contains(&self.volumes[v]) {
                if self.is_leaf(v) {
                    let (volume, basis) = self.span(u, capsules);
                    return (volume, Some(basis));
                }
                pending.extend(self.children(v));
            }
        }
        (candidate, None)
    }
}

fn chosen<'a>(
    segments: &'a [u32],
    capsules: &'a Capsules,
) -> impl Iterator<Item = Capsule> + Clone + 'a {
    segments.iter().map(|&segment| capsules.get(segment as usize))
}

/// All segments as if a thread ran through all fibers, up one and down the next.
fn thread(layout: &Layout) -> Vec<u32> {
    let mut order: Vec<u32> = (0..).take(layout.segments()).collect();
    for fiber in (1..layout.fibers()).step_by(2) {
        order[layout.segment_range(fiber)].reverse();
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_second_fiber_is_threaded_backward() {
        assert_eq!(thread(&Layout::new([3, 2, 1, 2])), [0, 1, 2, 4, 3, 5, 7, 6]);
    }
}
