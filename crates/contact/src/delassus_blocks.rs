use crate::ContactError;
use nalgebra::{DMatrix, Matrix3};
use rapunzel_lanes::LANES;

/// A vector for each of eight points or contacts, component by component, as registers hold them.
pub type VectorLanes<T> = [[T; LANES]; 3];

/// Delassus operator of some points, dense: how they answer impulses on each other. A symmetric
/// matrix, 1/kg, with three rows and columns a point, world.
///
/// Columns lie one after another, their rows by eight points side by side, filled up with zeros:
/// what an impulse does to all points is read in one go. For any point and any eight that is 576
/// bytes, or half of it in single precision, whose roundings move points by a ten-millionth of what
/// the impulses do.
#[derive(Debug, Clone, PartialEq)]
pub struct DelassusBlocks {
    points: usize,
    columns: DelassusColumns,
}

/// Columns of the matrix, one after another, in either precision.
#[derive(Debug, Clone, PartialEq)]
enum DelassusColumns {
    Single(Vec<VectorLanes<f32>>),
    Double(Vec<VectorLanes<f64>>),
}

/// Velocities of all points, m/s, world, that an impulse of 1 N s on one of them causes along each
/// axis: three columns of [`DelassusBlocks`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum UnitResponse<'a> {
    /// In single precision.
    Single([&'a [VectorLanes<f32>]; 3]),
    /// In double precision.
    Double([&'a [VectorLanes<f64>]; 3]),
}

impl DelassusBlocks {
    /// Blocks of a matrix, in double precision.
    ///
    /// # Errors
    /// [`ContactError::Length`] unless it is square with three rows a point, and
    /// [`ContactError::Invalid`] for an entry that is not finite.
    pub fn new(matrix: &DMatrix<f64>) -> Result<Self, ContactError> {
        let columns = DelassusColumns::Double(side_by_side(matrix, |x| x)?);
        Ok(Self { points: matrix.ncols() / 3, columns })
    }

    /// Blocks of a matrix, rounded to single precision.
    ///
    /// # Errors
    /// [`ContactError::Length`] unless it is square with three rows a point, and
    /// [`ContactError::Invalid`] for an entry that is not finite in single precision.
    pub fn rounded(matrix: &DMatrix<f64>) -> Result<Self, ContactError> {
        #[expect(clippy::cast_possible_truncation, reason = "rounding is what it is for")]
        let columns = DelassusColumns::Single(side_by_side(matrix, |x| x as f32)?);
        Ok(Self { points: matrix.ncols() / 3, columns })
    }

    /// Number of points.
    #[must_use]
    pub fn points(&self) -> usize {
        self.points
    }

    /// Velocities of all points that unit impulses on one point cause.
    ///
    /// # Panics
    /// If there is no such point, as indexing does.
    #[must_use]
    #[inline(always)]
    pub fn response_to(&self, point: usize) -> UnitResponse<'_> {
        match &self.columns {
            DelassusColumns::Single(columns) => {
                UnitResponse::Single(point_columns(columns, self.points, point))
            }
            DelassusColumns::Double(columns) => {
                UnitResponse::Double(point_columns(columns, self.points, point))
            }
        }
    }

    /// Block of the matrix, 1/kg: the answer of point `row` to impulses on point `column`.
    ///
    /// # Panics
    /// If there is no such point, as indexing does.
    #[must_use]
    pub fn block(&self, row: usize, column: usize) -> Matrix3<f64> {
        let (register, lane) = (row / LANES, row % LANES);
        match self.response_to(column) {
            UnitResponse::Single(columns) => {
                Matrix3::from_fn(|i, k| f64::from(columns[k][register][i][lane]))
            }
            UnitResponse::Double(columns) => Matrix3::from_fn(|i, k| columns[k][register][i][lane]),
        }
    }

    /// Bound below which a difference of blocks is rounding, relative to these.
    pub(crate) fn relative_rounding(&self) -> f64 {
        match &self.columns {
            DelassusColumns::Single(_) => 1e-6,
            DelassusColumns::Double(_) => 1e-13,
        }
    }
}

/// Columns of a matrix, their rows by eight points side by side.
fn side_by_side<T: Copy + Into<f64>>(
    matrix: &DMatrix<f64>,
    rounded: impl Fn(f64) -> T,
) -> Result<Vec<VectorLanes<T>>, ContactError> {
    let points = matrix.ncols() / 3;
    let sizes = [("columns of answers", matrix.ncols()), ("rows of answers", matrix.nrows())];
    if let Some((what, found)) = sizes.into_iter().find(|(_, size)| *size != 3 * points) {
        return Err(ContactError::Length { what, expected: 3 * points, found });
    }
    let size = points.div_ceil(LANES);
    let mut columns = vec![[[rounded(0.0); LANES]; 3]; 3 * points * size];
    for (to, from) in columns.chunks_exact_mut(size.max(1)).zip(matrix.column_iter()) {
        for (row, point) in from.as_slice().as_chunks::<3>().0.iter().enumerate() {
            for axis in 0..3 {
                to[row / LANES][axis][row % LANES] = rounded(point[axis]);
            }
        }
    }
    let all = columns.as_flattened().as_flattened();
    match all.iter().map(|&x| x.into()).find(|x| !x.is_finite()) {
        Some(value) => {
            Err(ContactError::Invalid { what: "answer", value, why: "it must be finite" })
        }
        None => Ok(columns),
    }
}

/// The three columns of a point.
#[inline(always)]
fn point_columns<T>(
    columns: &[VectorLanes<T>],
    points: usize,
    point: usize,
) -> [&[VectorLanes<T>]; 3] {
    let size = points.div_ceil(LANES);
    let (x, rest) = columns[3 * point * size..3 * (point + 1) * size].split_at(size);
    let (y, z) = rest.split_at(size);
    [x, y, z]
}
