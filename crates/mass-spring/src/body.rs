use crate::{Cells, Element, Lattice, PlaceMatrix, SpringError};

/// The five compressible bodies of the second text, with their clamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LatticeBody {
    /// Thin beam, 3 x 16 nodes: fixed at the left, guided along itself at the right.
    ThinBeamGuided,
    /// Thin beam, 3 x 16 nodes: fixed at the left.
    ThinBeam,
    /// Cube, 10 x 10 nodes: fixed on the ground.
    Cube,
    /// Cube, 10 x 10 nodes: fixed on the ground, under a lid that goes up and down.
    CubeUnderLid,
    /// Thick beam, 6 x 12 nodes: fixed at the left.
    ThickBeam,
}

impl LatticeBody {
    /// Number of rows and columns of nodes, which the text shows in a picture only.
    #[must_use]
    pub fn size(self) -> [usize; 2] {
        match self {
            Self::ThinBeamGuided | Self::ThinBeam => [3, 16],
            Self::Cube | Self::CubeUnderLid => [10, 10],
            Self::ThickBeam => [6, 12],
        }
    }

    /// The body with the clamps of the text and diagonals as stiff as the sides.
    ///
    /// # Errors
    /// [`SpringError`] if the lattice of that size has a place matrix that makes no sense.
    pub fn lattice(self, spacing: f64, element: Element) -> Result<Lattice, SpringError> {
        let [rows, columns] = self.size();
        let left = |_, column| column == 0;
        let ground = |row, _| row + 1 == rows;
        let free = PlaceMatrix::free(rows, columns)?;
        let place = match self {
            Self::ThinBeamGuided => {
                free.with('f', left).with('v', |_, column| column + 1 == columns)
            }
            Self::ThinBeam | Self::ThickBeam => free.with('f', left),
            Self::Cube => free.with('f', ground),
            Self::CubeUnderLid => free.with('f', ground).with('h', |row, _| row == 0),
        };
        Ok(Lattice { place, spacing, element, cells: Cells::Braced { ratio: 1.0 } })
    }
}
