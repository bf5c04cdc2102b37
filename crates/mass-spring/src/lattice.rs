use crate::error::positive;
use crate::{Element, PlaceMatrix, Spring, SpringError, System};
use nalgebra::{Point, SVector};
use std::f64::consts::SQRT_2;

/// Diagonal springs in the cells of a lattice, beside its four sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cells {
    /// No diagonals: the net of the second text, whose cells can fold over and stay so.
    Rectangular,
    /// One diagonal, toward the middle of the lattice, so that no corner can fold over, as the
    /// second text recommends.
    Triangular,
    /// Both diagonals, whose springs have `ratio` times the stiffness of the sides: the
    /// compressible bodies of the second text.
    Braced {
        /// Ratio of the stiffness of the diagonals to that of the sides.
        ratio: f64,
    },
}

/// Nodes in rows and columns: a net or a body.
///
/// The index of a node is `row * columns + column`; row 0 is at the top. The lattice lies in the
/// plane of the first axis, to the right, and the last one, up: x and y in the plane, x and z in
/// space.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice {
    /// Place matrix: the springs and supports of every node.
    pub place: PlaceMatrix,
    /// Rest length of the sides, m; diagonals rest at `sqrt(2)` times it (errata, section 9).
    pub spacing: f64,
    /// Parameters of the masses and springs.
    pub element: Element,
    /// Diagonals in the cells.
    pub cells: Cells,
}

impl Lattice {
    /// The net of the second text: 7.5 cm wide meshes, and masses of 10 g, which the text does not
    /// give.
    #[must_use]
    pub fn net(place: PlaceMatrix, frequency: f64, cells: Cells) -> Self {
        let element = Element { mass: 0.01, ..Element::unit(frequency) };
        Self { place, spacing: 0.075, element, cells }
    }

    /// Index of the node in a row and a column.
    #[must_use]
    pub fn node(&self, row: usize, column: usize) -> usize {
        row * self.place.columns() + column
    }

    /// The lattice at rest, its top left corner at `corner` (world), m.
    ///
    /// # Errors
    /// [`SpringError::Parameter`]; [`SpringError::Count`] in fewer than two dimensions.
    pub fn build<const D: usize>(&self, corner: Point<f64, D>) -> Result<System<D>, SpringError> {
        self.element.check()?;
        positive("the spacing of a lattice (m)", self.spacing)?;
        if D < 2 {
            let expected = "at least two".to_owned();
            return Err(SpringError::Count { what: "dimensions", found: D, expected });
        }
        let (rows, columns) = (self.place.rows(), self.place.columns());
        let position = |node: usize| {
            let mut offset = SVector::<f64, D>::zeros();
            offset[0] = (node % columns) as f64 * self.spacing;
            offset[D - 1] = -((node / columns) as f64) * self.spacing;
            corner + offset
        };
        let positions: Vec<_> = (0..rows * columns).map(position).collect();
        let masses = vec![self.element.mass; rows * columns];
        let mut system = System::new(&positions, &masses, &self.springs()?)?;
        system.set_drag(self.element.drag)?;
        self.support(&mut system)?;
        Ok(system)
    }

    /// Faces of the surface: the nodes of the whole cells, counter-clockwise as seen with the first
    /// axis to the right and the last one up; both halves of `Triangular` cells.
    #[must_use]
    pub fn faces(&self) -> Vec<Vec<usize>> {
        let (rows, columns) = (self.place.rows(), self.place.columns());
        let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        let faces = cells.filter(|&(row, column)| self.is_whole(row, column));
        let faces = faces.flat_map(|(row, column)| {
            let left = [row, row + 1].map(|row| self.node(row, column));
            let [[a, b], [d, c]] = [left, left.map(|node| node + 1)];
            match self.cells {
                Cells::Triangular if self.has_diagonal(row, column, true) => {
                    vec![vec![a, b, c], vec![a, c, d]]
                }
                Cells::Triangular => vec![vec![a, b, d], vec![b, c, d]],
                Cells::Rectangular | Cells::Braced { .. } => vec![vec![a, b, c, d]],
            }
        });
        faces.collect()
    }

    /// Springs of the lattice, row by row and kind by kind, so that they form long runs.
    fn springs(&self) -> Result<Vec<Spring>, SpringError> {
        let place = &self.place;
        let (rows, columns) = (place.rows(), place.columns());
        let side = Spring {
            damping: self.element.damping(),
            ..Spring::new([0, 0], self.element.stiffness(), self.spacing)
        };
        let mut springs = Vec::new();
        let mut connect = |a, b, spring: Spring| springs.push(Spring { nodes: [a, b], ..spring });
        for row in 0..rows {
            for column in (0..columns).filter(|&c| place.connected(row, c, 0, 1)) {
                connect(self.node(row, column), self.node(row, column + 1), side);
            }
            for column in (0..columns).filter(|&c| place.connected(row, c, 1, 0)) {
                connect(self.node(row, column), self.node(row + 1, column), side);
            }
            let ratio = match self.cells {
                Cells::Rectangular => continue,
                Cells::Triangular => 1.0,
                Cells::Braced { ratio } => ratio,
            };
            positive("the stiffness of the diagonals by that of the sides", ratio)?;
            let stiffness = ratio * side.stiffness;
            let diagonal = Spring { stiffness, rest_length: SQRT_2 * self.spacing, ..side };
            for down in [true, false] {
                for column in (0..columns).filter(|&c| self.has_diagonal(row, c, down)) {
                    let (left, right) = if down { (row, row + 1) } else { (row + 1, row) };
                    connect(self.node(left, column), self.node(right, column + 1), diagonal);
                }
            }
        }
        Ok(springs)
    }

    /// Whether the cell to the right and below of a node has all its sides.
    fn is_whole(&self, row: usize, column: usize) -> bool {
        let place = &self.place;
        place.connected(row, column, 0, 1)
            && place.connected(row, column, 1, 0)
            && place.connected(row + 1, column, 0, 1)
            && place.connected(row, column + 1, 1, 0)
    }

    /// Whether the cell to the right and below of a node is whole and has the diagonal from its top
    /// left (`down`) or its bottom left corner.
    fn has_diagonal(&self, row: usize, column: usize, down: bool) -> bool {
        let place = &self.place;
        // Which half of the lattice the middle of the cell lies in.
        let upper = 2 * row + 2 <= place.rows();
        let left = 2 * column + 2 <= place.columns();
        self.is_whole(row, column)
            && (matches!(self.cells, Cells::Braced { .. }) || down == (upper == left))
    }

    fn support<const D: usize>(&self, system: &mut System<D>) -> Result<(), SpringError> {
        for (row, column) in self.place.all('f') {
            system.pin(self.node(row, column))?;
        }
        for (letter, along) in [('h', D - 1), ('v', 0)] {
            let nodes: Vec<_> = self.place.all(letter).map(|(r, c)| self.node(r, c)).collect();
            for &node in &nodes {
                for axis in (0..D).filter(|&axis| axis != along) {
                    system.hold_axis(node, axis, 0.0)?;
                }
            }
            system.tie(&nodes, along)?;
        }
        Ok(())
    }
}
