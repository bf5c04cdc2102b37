//! How the points of one fibre answer impulses, written out.

use nalgebra::{Matrix3, RealField, Vector3, convert, convert_unchecked};
use pulp::{Arch, NullaryFnOnce};
use rapunzel_contact::{ContactError, DelassusBlocks, UnitResponse, VectorLanes};
use rapunzel_lanes::LANES;
use rapunzel_rod_dynamic::PointResponses;
use std::array::from_fn;

/// Rows of a strip: the lanes of the widest register in single precision.
const ROWS: usize = 16;
/// Columns that are taken at once.
const COLUMNS: usize = 4;

/// The Delassus operator of the points of one fibre, as a dense matrix.
pub(super) struct FiberDelassus {
    /// Which points they are, from root to tip.
    points: Vec<usize>,
    own: DelassusBlocks,
    /// Answers of the points with masses added to them.
    weighted: WeightedDelassus,
}

/// A matrix as precise as the solver needs it: half the bytes are half the time.
enum WeightedDelassus {
    Single(MatrixStrips<f32>),
    Double(MatrixStrips<f64>),
}

impl WeightedDelassus {
    /// The matrix of no points.
    const NONE: Self = Self::Double(MatrixStrips(Vec::new()));
}

impl FiberDelassus {
    /// The operator of given responses, in single precision unless `exact`.
    pub(super) fn new(own: PointResponses, exact: bool) -> Result<Self, ContactError> {
        let PointResponses { points, matrix } = own;
        let own =
            if exact { DelassusBlocks::new(&matrix)? } else { DelassusBlocks::rounded(&matrix)? };
        Ok(Self { points, own, weighted: WeightedDelassus::NONE })
    }

    /// Adds a mass at each point, one after another, with `W` the answer so far: a mass `m` at `i`
    /// leaves `W - W_i S W_i^T` of it, with the columns `W_i` and `S = (W_ii + 1/m)^-1`. In single
    /// precision unless `exact`. False if `W` is not positive semidefinite.
    pub(super) fn weigh(&mut self, masses: &[f64], exact: bool) -> bool {
        let masses = self.points.iter().map(|&point| masses[point]).collect();
        let (size, add) = (3 * self.points.len(), AddMasses { answers: &self.own, masses });
        let Some(lower) = Arch::new().dispatch(add) else { return false };
        self.weighted = if exact {
            WeightedDelassus::Double(MatrixStrips::new(&lower, stride(size), size))
        } else {
            WeightedDelassus::Single(MatrixStrips::new(&lower, stride(size), size))
        };
        true
    }

    /// Takes the masses away.
    pub(super) fn forget_weights(&mut self) {
        self.weighted = WeightedDelassus::NONE;
    }

    /// The points and their answers without masses.
    pub(super) fn own(&self) -> (&[usize], &DelassusBlocks) {
        (&self.points, &self.own)
    }

    /// The traces of the blocks of each point with itself, by point.
    pub(super) fn traces(&self, traces: &mut [f64]) {
        for (i, &point) in self.points.iter().enumerate() {
            traces[point] = self.own.block(i, i).trace();
        }
    }
}

/// A symmetric matrix in strips of rows, each column by column, filled up with zeros: a product
/// reads it from the first entry to the last.
struct MatrixStrips<T>(Vec<T>);

impl<T: RealField + Copy> MatrixStrips<T> {
    /// From the lower triangle of a matrix whose columns lie a `stride` apart.
    fn new(lower: &[f64], stride: usize, size: usize) -> Self {
        let columns = size.next_multiple_of(COLUMNS);
        let mut entries = vec![T::zero(); size.next_multiple_of(ROWS) * columns];
        let at = |i: usize, j: usize| (i / ROWS * columns + j) * ROWS + i % ROWS;
        for j in 0..size {
            for i in j..size {
                let entry = convert::<f64, T>(lower[j * stride + i]);
                entries[at(i, j)] = entry;
                entries[at(j, i)] = entry;
            }
        }
        Self(entries)
    }

    /// Writes the product with `from`; both are filled up as the matrix is.
    #[inline(always)]
    fn multiply(&self, from: &[T], to: &mut [T]) {
        let strips = self.0.chunks_exact(ROWS * from.len().max(1));
        for (strip, to) in strips.zip(to.as_chunks_mut::<ROWS>().0) {
            // Four sums that do not wait for each other.
            let zero = [T::zero(); ROWS];
            let (mut p, mut q, mut r, mut s) = (zero, zero, zero, zero);
            let columns = strip.as_chunks::<ROWS>().0.as_chunks::<COLUMNS>().0;
            for ([a, b, c, d], &[x, y, z, w]) in columns.iter().zip(from.as_chunks::<COLUMNS>().0) {
                for i in 0..ROWS {
                    p[i] += a[i] * x;
                    q[i] += b[i] * y;
                    r[i] += c[i] * z;
                    s[i] += d[i] * w;
                }
            }
            for i in 0..ROWS {
                to[i] = (p[i] + q[i]) + (r[i] + s[i]);
            }
        }
    }
}

impl MatrixStrips<f32> {
    /// The velocities of so few points that all are in one strip, which needs no workspace.
    #[inline(always)]
    fn multiply_few(
        &self,
        points: &[usize],
        impulses: &[Vector3<f64>],
        velocities: &mut [Vector3<f64>],
    ) {
        let (mut from, mut to) = ([0.0_f32; ROWS], [0.0_f32; ROWS]);
        for (from, &point) in from.as_chunks_mut::<3>().0.iter_mut().zip(points) {
            *from = convert_unchecked::<_, Vector3<f32>>(impulses[point]).into();
        }
        self.multiply(&from[..(3 * points.len()).next_multiple_of(COLUMNS)], &mut to);
        for (&to, &point) in to.as_chunks::<3>().0.iter().zip(points) {
            velocities[point] = convert(Vector3::from(to));
        }
    }
}

/// How far apart the columns are that masses are added to.
fn stride(size: usize) -> usize {
    size.next_multiple_of(LANES)
}

/// Adds masses; of the matrix that is left, with its stride, the lower triangle is right.
struct AddMasses<'a> {
    answers: &'a DelassusBlocks,
    masses: Vec<f64>,
}

impl NullaryFnOnce for AddMasses<'_> {
    type Output = Option<Vec<f64>>;

    #[inline(always)]
    fn call(self) -> Option<Vec<f64>> {
        let Self { answers, masses } = self;
        let size = 3 * answers.points();
        let stride = stride(size);
        let mut left = vec![0.0; stride * size];
        for (point, left) in left.chunks_exact_mut(3 * stride.max(1)).enumerate() {
            for row in 0..answers.points() {
                let block = answers.block(row, point);
                for (left, column) in left.chunks_exact_mut(stride).zip(block.column_iter()) {
                    left[3 * row..3 * row + 3].copy_from_slice(column.as_slice());
                }
            }
        }
        let mut columns = [(); 3].map(|()| vec![0.0; stride]);
        let mut shares = columns.clone();
        for (first, &mass) in (0..size).step_by(3).zip(&masses) {
            if mass <= 0.0 {
                continue;
            }
            for (k, column) in (first..).zip(&mut columns) {
                let (before, behind) = left.split_at(k * stride);
                let (above, below) = column.split_at_mut(k);
                for (x, other) in above.iter_mut().zip(before.chunks_exact(stride)) {
                    *x = other[k];
                }
                below.copy_from_slice(&behind[k..stride]);
            }
            let own = Matrix3::from_fn(|i, j| columns[j][first + i]);
            let inverse = inverse(&(own + Matrix3::from_diagonal_element(1.0 / mass)))?;
            let [a, b, c] = &columns;
            for (j, share) in shares.iter_mut().enumerate() {
                let [x, y, z] = [inverse[(0, j)], inverse[(1, j)], inverse[(2, j)]];
                for (((to, a), b), c) in share.iter_mut().zip(a).zip(b).zip(c) {
                    *to = x * a + y * b + z * c;
                }
            }
            for (block, left) in left.chunks_mut(COLUMNS * stride).enumerate() {
                let first = COLUMNS * block;
                let factors = |j: usize| [a[first + j], b[first + j], c[first + j]];
                // What is read of the shares serves some columns.
                if left.len() == COLUMNS * stride {
                    take::<COLUMNS>(left, stride, first, from_fn(factors), &shares);
                } else {
                    for (j, left) in left.chunks_exact_mut(stride).enumerate() {
                        take(left, stride, first, [factors(j)], &shares);
                    }
                }
            }
        }
        Some(left)
    }
}

/// The inverse of a symmetric matrix, by its cofactors; `None` if it is not positive definite.
#[inline(always)]
fn inverse(m: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let cofactor = |a: usize, b: usize| {
        let [[i, j], [k, l]] = [a, b].map(|x| [(x + 1) % 3, (x + 2) % 3]);
        m[(i, k)] * m[(j, l)] - m[(i, l)] * m[(j, k)]
    };
    let [xx, xy, xz] = [cofactor(0, 0), cofactor(0, 1), cofactor(0, 2)];
    let [yy, yz, zz] = [cofactor(1, 1), cofactor(1, 2), cofactor(2, 2)];
    let determinant = m[(0, 0)] * xx + m[(0, 1)] * xy + m[(0, 2)] * xz;
    let positive = m[(0, 0)] > 0.0 && zz > 0.0 && determinant > 0.0;
    positive.then(|| Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) / determinant)
}

/// Takes shares, times their factors, from columns, in rows from `first` on.
#[inline(always)]
fn take<const N: usize>(
    columns: &mut [f64],
    stride: usize,
    first: usize,
    factors: [[f64; 3]; N],
    [u, v, w]: &[Vec<f64>; 3],
) {
    let rows = stride / LANES;
    let columns = &mut columns.as_chunks_mut::<LANES>().0[..N * rows];
    let [u, v, w] = [u, v, w].map(|share| &share.as_chunks::<LANES>().0[..rows]);
    for row in first / LANES..rows {
        // By value: nobody else writes to them.
        let (u, v, w) = (u[row], v[row], w[row]);
        for (j, [x, y, z]) in factors.iter().enumerate() {
            let to = &mut columns[j * rows + row];
            let mut left = *to;
            for i in 0..LANES {
                left[i] -= x * u[i] + y * v[i] + z * w[i];
            }
            *to = left;
        }
    }
}

/// Which of the answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum InertiaKind {
    Own,
    Weighted,
}

/// Replaces impulses on points by the velocities that they cause, fibre by fibre.
pub(super) struct DelassusProduct<'a> {
    pub(super) explicit: &'a [FiberDelassus],
    pub(super) inertia: InertiaKind,
    pub(super) impulses: &'a [Vector3<f64>],
    pub(super) velocities: &'a mut [Vector3<f64>],
}

impl NullaryFnOnce for DelassusProduct<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { explicit, inertia, impulses, velocities } = self;
        let (mut single, mut double) = (ProductWorkspace::default(), ProductWorkspace::default());
        let mut side_by_side = Vec::new();
        // No closures: what is dispatched must be inlined into this.
        for FiberDelassus { points, own, weighted } in explicit {
            match (inertia, weighted) {
                (InertiaKind::Own, _) => {
                    gather(points, impulses, &mut side_by_side);
                    for (i, &point) in points.iter().enumerate() {
                        velocities[point] = match own.response_to(i) {
                            UnitResponse::Single(columns) => multiply(columns, &side_by_side),
                            UnitResponse::Double(columns) => multiply(columns, &side_by_side),
                        };
                    }
                }
                (InertiaKind::Weighted, WeightedDelassus::Single(matrix))
                    if 3 * points.len() <= ROWS =>
                {
                    matrix.multiply_few(points, impulses, velocities);
                }
                (InertiaKind::Weighted, WeightedDelassus::Single(matrix)) => {
                    single.gather(points, impulses);
                    matrix.multiply(&single.from, &mut single.to);
                    single.scatter(points, velocities);
                }
                (InertiaKind::Weighted, WeightedDelassus::Double(matrix)) => {
                    double.gather(points, impulses);
                    matrix.multiply(&double.from, &mut double.to);
                    double.scatter(points, velocities);
                }
            }
        }
    }
}

/// Impulses and velocities of one fibre.
#[derive(Default)]
struct ProductWorkspace<T> {
    from: Vec<T>,
    to: Vec<T>,
}

impl<T: RealField + Copy> ProductWorkspace<T> {
    /// Impulses of the points of the fibre, filled up with zeros, and room for velocities.
    #[inline(always)]
    fn gather(&mut self, points: &[usize], impulses: &[Vector3<f64>]) {
        let size = 3 * points.len();
        self.from.clear();
        self.from.resize(size.next_multiple_of(COLUMNS), T::zero());
        for (from, &point) in self.from.as_chunks_mut::<3>().0.iter_mut().zip(points) {
            let impulse = &impulses[point];
            *from = [convert(impulse.x), convert(impulse.y), convert(impulse.z)];
        }
        self.to.resize(size.next_multiple_of(ROWS), T::zero());
    }

    #[inline(always)]
    fn scatter(&self, points: &[usize], velocities: &mut [Vector3<f64>]) {
        for (&[x, y, z], &point) in self.to.as_chunks::<3>().0.iter().zip(points) {
            let velocity = [convert_unchecked(x), convert_unchecked(y), convert_unchecked(z)];
            velocities[point] = Vector3::from(velocity);
        }
    }
}

/// Impulses of the points of a fibre, side by side, filled up with zeros.
#[inline(always)]
fn gather(points: &[usize], impulses: &[Vector3<f64>], into: &mut Vec<VectorLanes<f64>>) {
    into.clear();
    into.resize(points.len().div_ceil(LANES), VectorLanes::<f64>::default());
    for (i, &point) in points.iter().enumerate() {
        for axis in 0..3 {
            into[i / LANES][axis][i % LANES] = impulses[point][axis];
        }
    }
}

/// The products of three columns with the impulses.
#[inline(always)]
fn multiply<T: Copy + Into<f64>>(
    columns: [&[VectorLanes<T>]; 3],
    impulses: &[VectorLanes<f64>],
) -> Vector3<f64> {
    let size = impulses.len();
    let [x, y, z] = columns;
    let (x, y, z) = (&x[..size], &y[..size], &z[..size]);
    let mut sums = [[[0.0; LANES]; 3]; 3];
    for i in 0..size {
        for axis in 0..3 {
            let of = impulses[i][axis];
            for lane in 0..LANES {
                sums[0][axis][lane] += x[i][axis][lane].into() * of[lane];
                sums[1][axis][lane] += y[i][axis][lane].into() * of[lane];
                sums[2][axis][lane] += z[i][axis][lane].into() * of[lane];
            }
        }
    }
    let mut products = Vector3::zeros();
    for k in 0..3 {
        let [a, b, c] = &sums[k];
        for lane in 0..LANES {
            products[k] += a[lane] + b[lane] + c[lane];
        }
    }
    products
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn only_positive_definite_matrices_have_an_inverse(
            entries in prop::array::uniform9(-1.0..1.0),
            shift in -0.5..0.5,
        ) {
            let root: Matrix3<f64> = Matrix3::from_row_slice(&entries);
            let m: Matrix3<f64> = root * root.transpose() + Matrix3::from_diagonal_element(shift);
            let least = m.symmetric_eigenvalues().min();
            prop_assume!(least.abs() > 1e-6);
            let inverse = inverse(&m);
            prop_assert_eq!(inverse.is_some(), least > 0.0);
            if let Some(inverse) = inverse {
                let error = (m * inverse - Matrix3::identity()).amax();
                prop_assert!(error < 1e-14 / (least * least), "{}", error);
            }
        }
    }
}
