//! A tree of boxes with eight children each, in single precision, for rays through many small
//! things.
//!
//! Coordinates are from a point in the middle of all, so that roundings are in proportion to the
//! extent of what the tree holds; boxes are grown by whoever makes them, [`rounding`], so that
//! none of them is missed for that.

mod bounds;
mod build;
mod node;
mod ray;
mod registers;
mod walk;

pub(crate) use bounds::{RayBox, rounding};
use node::RayNode;
pub(crate) use node::{LeafThings, NONE, WIDTH, short};
pub(crate) use ray::{SignBits, TreeRay, single};
pub(crate) use walk::{Leaves, RayQuery, walk};

/// A tree over things that were given by their boxes.
#[derive(Debug, Clone)]
pub(crate) struct RayTree {
    /// The first is the root; there is none without things.
    nodes: Vec<RayNode>,
}

impl RayTree {
    /// A tree over boxes, at most `2^31`, and its leaves.
    pub(crate) fn new(boxes: Vec<RayBox>) -> (Self, Vec<LeafThings>) {
        let (nodes, leaves) = build::build(boxes);
        (Self { nodes }, leaves)
    }

    /// Memory of the nodes, bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice())
    }
}
