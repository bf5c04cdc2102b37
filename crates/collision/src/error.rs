use thiserror::Error;

/// What can be wrong with what is to be searched for contacts.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CollisionError {
    /// There is nothing to search.
    #[error("there are no segments; give at least one fibre with at least one segment")]
    Empty,
    /// An array does not have the length that the fibres need.
    #[error("{what}: {given} were given, but the fibres need {needed}")]
    Count {
        /// Which array.
        what: &'static str,
        /// Its length.
        given: usize,
        /// The length that it must have.
        needed: usize,
    },
    /// A node is nowhere.
    #[error(
        "node {node} of fiber {fiber} is at ({}, {}, {}), but positions must be finite",
        position[0], position[1], position[2]
    )]
    Position {
        /// Index of the fibre.
        fiber: usize,
        /// Index of the node on the fibre.
        node: usize,
        /// The position that was given (world), m.
        position: [f64; 3],
    },
    /// A segment has no thickness, or one that is no length.
    #[error(
        "segment {segment} of fiber {fiber} has radius {radius} m, but it must be positive and finite"
    )]
    Radius {
        /// Index of the fibre.
        fiber: usize,
        /// Index of the segment on the fibre.
        segment: usize,
        /// The radius that was given, m.
        radius: f64,
    },
    /// A polytope cannot have so many faces.
    #[error("a k-DOP with {k} faces is asked for, but k must be even and at least 6")]
    Directions {
        /// The number that was given.
        k: usize,
    },
    /// Two trees cannot be searched against each other.
    #[error(
        "the two trees have different bounding volumes; build both of the same variant, with the \
         same directions"
    )]
    Volumes,
}
