use serde::{Deserialize, Serialize};

/// A node of a fibre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum JointNode {
    /// The first node.
    Root,
    /// The last node.
    Tip,
    /// The node with this number from the root, which is 0.
    Node(usize),
}

impl JointNode {
    /// Its number in a fibre of so many segments.
    #[must_use]
    pub fn number(self, segments: usize) -> usize {
        match self {
            Self::Root => 0,
            Self::Tip => segments,
            Self::Node(number) => number,
        }
    }
}
