//! A tree of boxes with eight children each, in single precision, for rays through many small
//! things.
//!
//! Coordinates are from a point in the middle of all, so that roundings are in proportion to the
//! extent of what the tree holds; boxes are grown by whoever makes them, [`rounding`], so that
//! none of them is missed for that.

mod bounds;
mod build;
mod ray;
mod walk;

pub(crate) use bounds::{Bounds, rounding};
pub(crate) use ray::{SignBits, TreeRay, single};
pub(crate) use walk::{Leaves, Walk, walk};

/// Children of a node, and things in a leaf.
pub(crate) const WIDTH: usize = 8;

/// A child or a thing that is not there.
pub(crate) const NONE: u32 = u32::MAX;
/// The bit of a child that is a leaf.
const LEAF: u32 = 1 << 31;

/// Indices of the things of a leaf, [`NONE`] where there is none.
pub(crate) type Leaf = [u32; WIDTH];

/// A count as it is stored; of more than `2^32` things there is no tree.
pub(crate) fn short(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

/// Eight boxes and what is in them.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
struct Node {
    low: [[f32; WIDTH]; 3],
    high: [[f32; WIDTH]; 3],
    /// Indices of nodes, or of leaves with the bit [`LEAF`].
    children: [u32; WIDTH],
}

impl Node {
    /// No box at all: what is empty is met by no ray.
    const EMPTY: Self = Self {
        low: [[f32::INFINITY; WIDTH]; 3],
        high: [[f32::NEG_INFINITY; WIDTH]; 3],
        children: [NONE; WIDTH],
    };

    fn set(&mut self, lane: usize, bounds: &Bounds, child: u32) {
        for d in 0..3 {
            self.low[d][lane] = bounds.low(d);
            self.high[d][lane] = bounds.high(d);
        }
        self.children[lane] = child;
    }
}

/// A tree over things that were given by their boxes.
#[derive(Debug, Clone)]
pub(crate) struct Tree {
    /// The first is the root; there is none without things.
    nodes: Vec<Node>,
}

impl Tree {
    /// A tree over boxes, at most `2^31`, and its leaves.
    pub(crate) fn new(boxes: Vec<Bounds>) -> (Self, Vec<Leaf>) {
        let (nodes, leaves) = build::build(boxes);
        (Self { nodes }, leaves)
    }

    /// Memory of the nodes, bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice())
    }
}
