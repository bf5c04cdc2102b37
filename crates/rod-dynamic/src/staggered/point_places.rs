//! Where in the arrays of a batch points of its fibres have their numbers.

use crate::Point;
use pulp::Simd;
use std::ops::RangeInclusive;

/// Places that bear impulses, in order, each by where the first number of its vector is in the
/// arrays of the batch.
#[derive(Default)]
pub(super) struct PressedPlaces {
    pub(super) nodes: Vec<usize>,
    pub(super) segments: Vec<usize>,
}

impl PressedPlaces {
    pub(super) fn is_empty(&self) -> bool {
        self.nodes.is_empty() && self.segments.is_empty()
    }

    pub(super) fn sort(&mut self) {
        for places in [&mut self.nodes, &mut self.segments] {
            places.sort_unstable();
            places.dedup();
        }
    }
}

/// Where the components of a vector are that begins at a place.
pub(super) fn components<S: Simd>(place: usize) -> [usize; 3] {
    [0, 1, 2].map(|i| place + i * S::F64_LANES)
}

/// Index range, in an array of vectors, from the first number of the node before a point to the
/// last number of the node behind it.
pub(super) fn both_nodes<S: Simd>(point: &Point) -> RangeInclusive<usize> {
    let first = 3 * S::F64_LANES * point.segment as usize + point.fiber as usize;
    first..=first + 5 * S::F64_LANES
}

/// Index range, in an array of vectors, of all numbers of the segment of a point.
pub(super) fn segment<S: Simd>(point: &Point) -> RangeInclusive<usize> {
    let first = 3 * S::F64_LANES * point.segment as usize + point.fiber as usize;
    first..=first + 2 * S::F64_LANES
}
