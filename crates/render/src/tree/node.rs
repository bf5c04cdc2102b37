use super::bounds::RayBox;

/// Children of a node, and things in a leaf.
pub(crate) const WIDTH: usize = 8;

/// A child or a thing that is not there.
pub(crate) const NONE: u32 = u32::MAX;
/// The bit of a child that is a leaf.
pub(super) const LEAF: u32 = 1 << 31;

/// Indices of the things of a leaf, [`NONE`] where there is none.
pub(crate) type LeafThings = [u32; WIDTH];

/// A count as it is stored; of more than `2^32` things there is no tree.
pub(crate) fn short(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

/// Eight boxes and what is in them.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub(super) struct RayNode {
    pub(super) low: [[f32; WIDTH]; 3],
    pub(super) high: [[f32; WIDTH]; 3],
    /// Indices of nodes, or of leaves with the bit [`LEAF`].
    pub(super) children: [u32; WIDTH],
}

impl RayNode {
    /// No box at all: what is empty is met by no ray.
    pub(super) const EMPTY: Self = Self {
        low: [[f32::INFINITY; WIDTH]; 3],
        high: [[f32::NEG_INFINITY; WIDTH]; 3],
        children: [NONE; WIDTH],
    };

    pub(super) fn set(&mut self, lane: usize, bounds: &RayBox, child: u32) {
        for d in 0..3 {
            self.low[d][lane] = bounds.low(d);
            self.high[d][lane] = bounds.high(d);
        }
        self.children[lane] = child;
    }
}
