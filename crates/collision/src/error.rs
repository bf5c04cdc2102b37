use thiserror::Error;

/// What can be wrong with what is to be searched for contacts.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CollisionError {
    /// There is nothing to search.
    #[error("there are no segments; give at least one fibre with at least one segment")]
    Empty,
    /// There are more nodes than can be numbered.
    #[error("{nodes} nodes are more than 2^32 - 1; search in parts")]
    TooMany {
        /// Number of nodes.
        nodes: usize,
    },
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
    /// How near something must be is no length.
    #[error("{what} is {value} m, but it must be finite and not negative")]
    Length {
        /// Which length.
        what: &'static str,
        /// The value that was given, m.
        value: f64,
    },
    /// A terrain cannot be made of these heights.
    #[error("heights of a terrain: {problem}")]
    Heights {
        /// What must be changed.
        problem: &'static str,
    },
    /// A grid cannot hold the field.
    #[error("grid of distances: {problem}")]
    Grid {
        /// What must be changed.
        problem: &'static str,
    },
    /// A mesh is empty.
    #[error("the mesh has no triangles; give a closed surface")]
    NoTriangles,
    /// A vertex of a mesh is nowhere.
    #[error(
        "vertex {vertex} of the mesh is at ({}, {}, {}), but positions must be finite",
        position[0], position[1], position[2]
    )]
    Vertex {
        /// Index of the vertex.
        vertex: usize,
        /// The position that was given (world), m.
        position: [f64; 3],
    },
    /// A triangle of a mesh is none.
    #[error("face {face} of the mesh {problem}")]
    Face {
        /// Index of the triangle.
        face: usize,
        /// What is wrong with it, and what can be done.
        problem: &'static str,
    },
    /// The mesh is not a closed, oriented surface at an edge.
    #[error("the edge of face {face} of the mesh from vertex {} to {} {problem}", vertices[0], vertices[1])]
    Edge {
        /// Index of a triangle at the edge.
        face: usize,
        /// Indices of the vertices at its ends.
        vertices: [u32; 2],
        /// What is wrong with it, and what can be done.
        problem: &'static str,
    },
    /// The triangles of a mesh face inward, or bound nothing.
    #[error(
        "the volume inside the mesh is not positive; reverse the order of the corners of its faces"
    )]
    InsideOut,
    /// A file of a mesh cannot be read.
    #[error(
        "this cannot be read as {format}: {}{problem}",
        line.map_or_else(String::new, |line| format!("line {line}: "))
    )]
    Read {
        /// Name of the format.
        format: &'static str,
        /// Line, from 1, if the problem is in one.
        line: Option<usize>,
        /// What its reader says.
        problem: String,
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
