use std::ops::Range;

/// Strands that are shown as one prim.
#[derive(Debug, Clone, PartialEq)]
pub struct Prim {
    /// Name of the prim: letters, digits and `_`.
    pub name: String,
    /// Kind of the prim.
    pub shape: PrimShape,
    /// Colour as red, green and blue, linear, in `[0, 1]`.
    pub color: [f64; 3],
}

/// Kinds of prims that strands are shown as.
#[derive(Debug, Clone, PartialEq)]
pub enum PrimShape {
    /// `BasisCurves`, straight between the points as they were simulated.
    Curves {
        /// Range of the strands.
        strands: Range<usize>,
        /// Whether the curves are guides, shown in the viewport but not rendered.
        guide: bool,
    },
    /// A `Mesh` whose vertices are points of strands.
    Surface {
        /// The strand of each vertex, and the index of the point in it.
        vertices: Vec<[usize; 2]>,
        /// The vertices of each face, in order.
        faces: Vec<Vec<usize>>,
    },
}

/// Names of the files of the value clips of a layer, relative to its folder.
#[derive(Debug, Clone, PartialEq)]
pub struct Clips {
    /// Name of the manifest, which lists the attributes of the clips.
    pub manifest: String,
    /// Name of each clip with its range of consecutive frames.
    pub files: Vec<(Range<usize>, String)>,
}
