//! How the points of one fibre answer impulses, written out.

use nalgebra::{Matrix3, RealField, Vector3, convert, convert_unchecked};
use pulp::{Arch, NullaryFnOnce};
use rapunzel_rod_dynamic::PointResponses;

/// Rows of a strip: the lanes of the widest register in single precision.
const ROWS: usize = 16;
/// Columns that a product takes at once.
const COLUMNS: usize = 4;

/// The answers of the points of one fibre.
pub(super) struct Explicit {
    own: PointResponses,
    /// The same with masses added.
    weighted: Weighted,
    /// The own answers in strips.
    strips: Strips<f64>,
}

/// A matrix as precise as the solver needs it: half the bytes are half the time.
enum Weighted {
    Single(Strips<f32>),
    Double(Strips<f64>),
}

impl Explicit {
    pub(super) fn new(own: PointResponses) -> Self {
        let strips = Strips::new(own.matrix.as_slice(), own.matrix.nrows());
        Self { own, weighted: Weighted::Double(Strips::new(&[], 0)), strips }
    }

    /// Adds a mass at each point, one after another, with `W` the answer so far: a mass `m` at `i`
    /// leaves `W - W_i S W_i^T` of it, with the columns `W_i` and `S = (W_ii + 1/m)^-1`. In single
    /// precision unless `exact`. False if `W` is not positive semidefinite.
    pub(super) fn weigh(&mut self, masses: &[f64], exact: bool) -> bool {
        let PointResponses { points, matrix } = &self.own;
        let (size, masses) = (matrix.nrows(), points.iter().map(|&point| masses[point]).collect());
        let add = AddMasses { answers: matrix.as_slice(), size, masses };
        let Some(lower) = Arch::new().dispatch(add) else { return false };
        self.weighted = if exact {
            Weighted::Double(Strips::new(&lower, size))
        } else {
            Weighted::Single(Strips::new(&lower, size))
        };
        true
    }

    /// The traces of the blocks of each point with itself, by point.
    pub(super) fn traces(&self, traces: &mut [f64]) {
        for (i, &point) in self.own.points.iter().enumerate() {
            traces[point] = self.own.matrix.fixed_view::<3, 3>(3 * i, 3 * i).trace();
        }
    }
}

/// A symmetric matrix in strips of rows, each column by column, filled up with zeros: a product reads
/// it from the first entry to the last.
struct Strips<T> {
    size: usize,
    entries: Vec<T>,
}

impl<T: RealField + Copy> Strips<T> {
    /// From the lower triangle of a matrix that is stored column by column.
    fn new(lower: &[f64], size: usize) -> Self {
        let columns = size.next_multiple_of(COLUMNS);
        let mut entries = vec![T::zero(); size.next_multiple_of(ROWS) * columns];
        let at = |i: usize, j: usize| (i / ROWS * columns + j) * ROWS + i % ROWS;
        for j in 0..size {
            for i in j..size {
                let entry = convert::<f64, T>(lower[j * size + i]);
                entries[at(i, j)] = entry;
                entries[at(j, i)] = entry;
            }
        }
        Self { size, entries }
    }

    /// Writes the product with `from`; both are filled up as the matrix is.
    #[inline(always)]
    fn multiply(&self, from: &[T], to: &mut [T]) {
        let strips = self.entries.chunks_exact(ROWS * from.len().max(1));
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

/// Adds masses; of the matrix that is left the lower triangle is right.
struct AddMasses<'a> {
    /// Symmetric, column by column.
    answers: &'a [f64],
    size: usize,
    masses: Vec<f64>,
}

impl NullaryFnOnce for AddMasses<'_> {
    type Output = Option<Vec<f64>>;

    #[inline(always)]
    fn call(self) -> Option<Vec<f64>> {
        let Self { answers, size, masses } = self;
        let mut left = answers.to_vec();
        let mut columns = [(); 3].map(|()| vec![0.0; size]);
        let mut shares = columns.clone();
        for (first, &mass) in (0..size).step_by(3).zip(&masses) {
            if mass <= 0.0 {
                continue;
            }
            for (k, column) in (first..).zip(&mut columns) {
                let (before, behind) = left.split_at(k * size);
                let (above, below) = column.split_at_mut(k);
                for (x, other) in above.iter_mut().zip(before.chunks_exact(size)) {
                    *x = other[k];
                }
                below.copy_from_slice(&behind[k..size]);
            }
            let own = Matrix3::from_fn(|i, j| columns[j][first + i]);
            let inverse = (own + Matrix3::from_diagonal_element(1.0 / mass)).cholesky()?.inverse();
            let [a, b, c] = &columns;
            for (j, share) in shares.iter_mut().enumerate() {
                let [x, y, z] = [inverse[(0, j)], inverse[(1, j)], inverse[(2, j)]];
                for (((to, a), b), c) in share.iter_mut().zip(a).zip(b).zip(c) {
                    *to = x * a + y * b + z * c;
                }
            }
            let [u, v, w] = &shares;
            for (j, left) in left.chunks_exact_mut(size).enumerate() {
                let [x, y, z] = [a[j], b[j], c[j]];
                let shares = u[j..].iter().zip(&v[j..]).zip(&w[j..]);
                for (to, ((u, v), w)) in left[j..].iter_mut().zip(shares) {
                    *to -= x * u + y * v + z * w;
                }
            }
        }
        Some(left)
    }
}

/// Which of the answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Inertia {
    Own,
    Weighted,
}

/// Replaces impulses on points by the velocities that they cause, fibre by fibre.
pub(super) struct Answer<'a> {
    pub(super) explicit: &'a [Explicit],
    pub(super) inertia: Inertia,
    pub(super) impulses: &'a [Vector3<f64>],
    pub(super) velocities: &'a mut [Vector3<f64>],
}

impl NullaryFnOnce for Answer<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { explicit, inertia, impulses, velocities } = self;
        let (mut single, mut double) = (Room::default(), Room::default());
        for Explicit { own: PointResponses { points, .. }, weighted, strips } in explicit {
            match (inertia, weighted) {
                (Inertia::Own, _) => double.answer(strips, points, impulses, velocities),
                (Inertia::Weighted, Weighted::Single(matrix)) => {
                    single.answer(matrix, points, impulses, velocities);
                }
                (Inertia::Weighted, Weighted::Double(matrix)) => {
                    double.answer(matrix, points, impulses, velocities);
                }
            }
        }
    }
}

/// Impulses and velocities of one fibre.
#[derive(Default)]
struct Room<T> {
    from: Vec<T>,
    to: Vec<T>,
}

impl<T: RealField + Copy> Room<T> {
    #[inline(always)]
    fn answer(
        &mut self,
        matrix: &Strips<T>,
        points: &[usize],
        impulses: &[Vector3<f64>],
        velocities: &mut [Vector3<f64>],
    ) {
        self.from.clear();
        self.from.resize(matrix.size.next_multiple_of(COLUMNS), T::zero());
        for (from, &point) in self.from.as_chunks_mut::<3>().0.iter_mut().zip(points) {
            *from = impulses[point].map(|x| convert::<f64, T>(x)).into();
        }
        self.to.resize(matrix.size.next_multiple_of(ROWS), T::zero());
        matrix.multiply(&self.from, &mut self.to);
        for (to, &point) in self.to.as_chunks::<3>().0.iter().zip(points) {
            velocities[point] = Vector3::from(*to).map(|x| convert_unchecked::<T, f64>(x));
        }
    }
}
