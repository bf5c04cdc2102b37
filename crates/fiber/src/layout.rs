//! Positions of the nodes and segments of many fibres in common arrays.

use std::ops::Range;

/// The nodes and segments that belong to each fibre, as ranges of common arrays.
///
/// Everything that lives on nodes (positions, velocities, radii) is stored fibre after fibre in
/// one array of [`Layout::nodes`] elements, everything on segments in one of
/// [`Layout::segments`] elements. Segment `j` of fibre `f` ends in the nodes `j + f` and
/// `j + f + 1`, because every fibre has one more node than segments.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// Index of the first segment of every fibre, and the total at the end.
    segment_offsets: Vec<usize>,
    /// Index of the fibre of every segment.
    segment_fibers: Vec<usize>,
}

impl Layout {
    /// Lays out fibres of the given numbers of segments, in their order.
    #[must_use]
    pub fn new(segments: impl IntoIterator<Item = usize>) -> Self {
        let mut segment_offsets = vec![0];
        let mut segment_fibers = Vec::new();
        for (f, count) in segments.into_iter().enumerate() {
            segment_fibers.resize(segment_fibers.len() + count, f);
            segment_offsets.push(segment_fibers.len());
        }
        Self { segment_offsets, segment_fibers }
    }

    /// Number of fibres.
    #[must_use]
    pub fn fibers(&self) -> usize {
        self.segment_offsets.len() - 1
    }

    /// Total number of nodes.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.segments() + self.fibers()
    }

    /// Total number of segments.
    #[must_use]
    pub fn segments(&self) -> usize {
        self.segment_fibers.len()
    }

    /// Range of fibre `fiber` in arrays over nodes.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    #[must_use]
    pub fn node_range(&self, fiber: usize) -> Range<usize> {
        self.segment_offsets[fiber] + fiber..self.segment_offsets[fiber + 1] + fiber + 1
    }

    /// Range of fibre `fiber` in arrays over segments.
    ///
    /// # Panics
    /// If there is no such fibre, as indexing does.
    #[must_use]
    pub fn segment_range(&self, fiber: usize) -> Range<usize> {
        self.segment_offsets[fiber]..self.segment_offsets[fiber + 1]
    }

    /// Index of the fibre of every segment.
    #[must_use]
    pub fn segment_fibers(&self) -> &[usize] {
        &self.segment_fibers
    }

    /// Indices of the two end nodes of `segment`, root side first.
    ///
    /// # Panics
    /// If there is no such segment, as indexing does.
    #[must_use]
    pub fn segment_nodes(&self, segment: usize) -> [usize; 2] {
        let first = segment + self.segment_fibers[segment];
        [first, first + 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn ranges_tile_the_arrays(counts in prop::collection::vec(1..6_usize, 0..40)) {
            let a = Layout::new(counts.iter().copied());
            let (mut node, mut segment) = (0, 0);
            for (f, &n) in counts.iter().enumerate() {
                prop_assert_eq!(a.node_range(f), node..node + n + 1);
                prop_assert_eq!(a.segment_range(f), segment..segment + n);
                for j in 0..n {
                    prop_assert_eq!(a.segment_fibers()[segment + j], f);
                    prop_assert_eq!(a.segment_nodes(segment + j), [node + j, node + j + 1]);
                }
                (node, segment) = (node + n + 1, segment + n);
            }
            prop_assert_eq!((a.fibers(), a.nodes(), a.segments()), (counts.len(), node, segment));
        }
    }
}
