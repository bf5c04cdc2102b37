//! Many fibres laid out in common arrays, for hot loops.

use crate::{Fiber, Layout};
use std::ops::Range;

/// The largest number of fibres in a group: eight `f64` fill the widest vector register in use.
pub const GROUP_SIZE: usize = 8;

/// Many fibres whose nodes and segments lie in common arrays, see [`Layout`].
///
/// A stepper walks over [`Assembly::groups`], fibres of equal segment count that can be advanced
/// side by side; collision detection walks over segments and looks up their fibre.
#[derive(Debug, Clone, PartialEq)]
pub struct Assembly {
    fibers: Vec<Fiber>,
    layout: Layout,
    /// Equivalent radius at every node, m.
    radii: Vec<f64>,
    /// Indices of the fibres, sorted by segment count and then by index.
    order: Vec<usize>,
    /// The groups as ranges in `order`.
    groups: Vec<Range<usize>>,
}

impl Assembly {
    /// Lays out `fibers`, which keep their order and so their indices. The list may be empty.
    #[must_use]
    pub fn new(fibers: Vec<Fiber>) -> Self {
        let layout = Layout::new(fibers.iter().map(Fiber::segments));
        let nodes = fibers.iter().flat_map(Fiber::nodes);
        let radii = nodes.map(|node| node.section.equivalent_radius()).collect();
        let mut order: Vec<usize> = (0..fibers.len()).collect();
        order.sort_by_key(|&f| fibers[f].segments());
        let groups = groups(&order, |f| fibers[f].segments());
        Self { fibers, layout, radii, order, groups }
    }

    /// The fibres, in the order in which they were given.
    #[must_use]
    pub fn fibers(&self) -> &[Fiber] {
        &self.fibers
    }

    /// Positions of the nodes and segments of every fibre in the common arrays.
    #[must_use]
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Radius of the circle with the area of the section at every node, m.
    #[must_use]
    pub fn radii(&self) -> &[f64] {
        &self.radii
    }

    /// Groups of at most [`GROUP_SIZE`] fibres of equal segment count, as indices of fibres.
    ///
    /// Every fibre is in one group. The order depends on the segment counts alone: fewest segments
    /// first, then by index.
    pub fn groups(&self) -> impl ExactSizeIterator<Item = &[usize]> {
        self.groups.iter().map(|group| &self.order[group.clone()])
    }

    /// Cuts an array over nodes into one mutable slice per fibre, for a loop over fibres that
    /// writes in parallel.
    ///
    /// # Panics
    /// If `data` does not have one element per node.
    pub fn split_nodes_mut<'a, T>(&self, data: &'a mut [T]) -> Vec<&'a mut [T]> {
        assert_eq!(data.len(), self.layout.nodes(), "an array over nodes has one element per node");
        let mut rest = data;
        let take = |fiber: &Fiber| {
            let (head, tail) = std::mem::take(&mut rest).split_at_mut(fiber.segments() + 1);
            rest = tail;
            head
        };
        self.fibers.iter().map(take).collect()
    }
}

/// Cuts `order`, sorted by `count`, into ranges of equal count and at most [`GROUP_SIZE`].
fn groups(order: &[usize], count: impl Fn(usize) -> usize) -> Vec<Range<usize>> {
    let mut groups = Vec::new();
    let mut first = 0;
    for equal in order.chunk_by(|&a, &b| count(a) == count(b)) {
        for group in equal.chunks(GROUP_SIZE) {
            groups.push(first..first + group.len());
            first += group.len();
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Material, Section};
    use proptest::prelude::*;

    fn assembly(counts: &[usize]) -> Assembly {
        let section = Section::Circle { radius: 35e-6 };
        let fiber = |&n: &usize| Fiber::uniform(0.1, n, section, &Material::HAIR).expect("valid");
        Assembly::new(counts.iter().map(fiber).collect())
    }

    proptest! {
        #[test]
        fn groups_hold_every_fiber_once(counts in prop::collection::vec(1..6_usize, 0..40)) {
            let a = assembly(&counts);
            let mut seen: Vec<usize> = a.groups().flatten().copied().collect();
            seen.sort_unstable();
            prop_assert_eq!(seen, (0..counts.len()).collect::<Vec<_>>());
            for group in a.groups() {
                prop_assert!(group.len() <= GROUP_SIZE);
                prop_assert!(group.iter().all(|&f| counts[f] == counts[group[0]]));
                prop_assert!(group.is_sorted());
            }
            // No more groups than needed: each count fills its groups but for the last.
            let needed: usize =
                (1..6).map(|n| counts.iter().filter(|&&c| c == n).count().div_ceil(GROUP_SIZE)).sum();
            prop_assert_eq!(a.groups().len(), needed);
        }
    }

    #[test]
    fn slices_per_fiber_are_the_node_ranges() {
        let a = assembly(&[3, 1, 2]);
        let mut data: Vec<usize> = (0..a.layout().nodes()).collect();
        let slices = a.split_nodes_mut(&mut data);
        assert_eq!(slices.len(), 3);
        for (f, slice) in slices.iter().enumerate() {
            assert_eq!(slice.to_vec(), a.layout().node_range(f).collect::<Vec<_>>());
        }
    }
}
