//! What a joint between two nodes is.

/// A node of a fibre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FiberPlace {
    /// Index of the fibre in the assembly.
    pub fiber: usize,
    /// Index of the node, from the root.
    pub node: usize,
}

/// What a joint holds beside the nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Connection {
    /// Nothing: a ball joint.
    Ball,
    /// The angle at which the segments before the nodes, at a root behind it, are at the start:
    /// what is between their middles bends and twists as their fibres do.
    Stiff,
    /// A tip and a root as one fibre: what is between bends and twists as within a fibre. The
    /// root's fibre goes on turned about the tangent.
    Spliced {
        /// Angle by which it is turned back, rad: a straight fibre that is closed to a ring gets as
        /// much twist.
        twist: f64,
    },
}

/// A joint between two nodes that lie at the same place.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeJoint {
    /// What errors call it.
    pub name: String,
    /// The two nodes; of a spliced joint the tip comes first.
    pub places: [FiberPlace; 2],
    /// What it holds beside the nodes.
    pub connection: Connection,
    /// Retardation time of the internal damping of what bends at it, s: of the mean strain rate
    /// over a step.
    pub damping_time: f64,
}
