use crate::ContactError;
use nalgebra::{DMatrix, Matrix3};

/// Points whose numbers lie side by side.
pub(crate) const LANES: usize = 8;

/// A vector for each of eight points, component by component: what a register holds.
pub type Eight = [[f64; LANES]; 3];

/// How some points answer impulses on each other: a symmetric matrix, 1/kg, three rows and columns a point.
///
/// Columns lie one after another, their rows by eight points side by side, filled up with zeros: what an
/// impulse does to all points is read in one go. 576 bytes for any point and any eight.
#[derive(Debug, Clone, PartialEq)]
pub struct Answers {
    points: usize,
    columns: Vec<Eight>,
}

impl Answers {
    /// The answers of a matrix.
    ///
    /// # Errors
    /// [`ContactError::Length`] unless it is square with three rows a point, and [`ContactError::Invalid`] for
    /// an entry that is not finite.
    pub fn new(matrix: &DMatrix<f64>) -> Result<Self, ContactError> {
        let points = matrix.ncols() / 3;
        for (what, found) in
            [("columns of answers", matrix.ncols()), ("rows of answers", matrix.nrows())]
        {
            if found != 3 * points {
                return Err(ContactError::Length { what, expected: 3 * points, found });
            }
        }
        if let Some(&value) = matrix.iter().find(|x| !x.is_finite()) {
            let (what, why) = ("answer", "it must be finite");
            return Err(ContactError::Invalid { what, value, why });
        }
        let size = points.div_ceil(LANES);
        let mut columns = vec![[[0.0; LANES]; 3]; 3 * points * size];
        for (to, from) in columns.chunks_exact_mut(size.max(1)).zip(matrix.column_iter()) {
            for (row, point) in from.as_slice().as_chunks::<3>().0.iter().enumerate() {
                for axis in 0..3 {
                    to[row / LANES][axis][row % LANES] = point[axis];
                }
            }
        }
        Ok(Self { points, columns })
    }

    /// Number of points.
    #[must_use]
    pub fn points(&self) -> usize {
        self.points
    }

    /// The velocities of all points, m/s, that an impulse of 1 N s on one causes, along each axis.
    ///
    /// # Panics
    /// If there is no such point, as indexing does.
    #[must_use]
    #[inline(always)]
    pub fn of(&self, point: usize) -> [&[Eight]; 3] {
        let size = self.points.div_ceil(LANES);
        let (x, rest) = self.columns[3 * point * size..3 * (point + 1) * size].split_at(size);
        let (y, z) = rest.split_at(size);
        [x, y, z]
    }

    /// The answer of one point to an impulse on another.
    ///
    /// # Panics
    /// As [`Self::of`].
    #[must_use]
    pub fn block(&self, row: usize, column: usize) -> Matrix3<f64> {
        let columns = self.of(column);
        Matrix3::from_fn(|i, k| columns[k][row / LANES][i][row % LANES])
    }
}
