//! How the points of one fibre answer impulses, written out.

use nalgebra::{RealField, Vector3, convert, convert_unchecked};
use pulp::{Arch, NullaryFnOnce};
use rapunzel_rod_dynamic::PointResponses;

/// Columns are filled up to a multiple of this many rows, so that loops over them leave no rest.
const ROWS: usize = 16;
/// Columns that a product takes at once.
const COLUMNS: usize = 4;

/// The answers of the points of one fibre.
pub(super) struct Explicit {
    own: PointResponses,
    /// With masses added.
    weighted: Weighted,
    /// Of the weighted matrix, column by column.
    stride: usize,
}

/// A matrix as precise as the solver needs it: half the bytes are half the time.
enum Weighted {
    Single(Vec<f32>),
    Double(Vec<f64>),
}

impl Explicit {
    pub(super) fn new(own: PointResponses) -> Self {
        let stride = own.matrix.nrows().next_multiple_of(ROWS);
        Self { own, weighted: Weighted::Double(Vec::new()), stride }
    }

    /// Adds a mass at each point, one after another: a mass `m` at `i` leaves
    /// `W - W e_i e_i^T W m/(1 + m W_ii)` of the answer `W`. In single precision unless `exact`.
    /// False if `W` is not positive semidefinite.
    pub(super) fn weigh(&mut self, masses: &[f64], exact: bool) -> bool {
        let (size, stride) = (self.own.matrix.nrows(), self.stride);
        let mut matrix = vec![0.0; stride * size];
        if size == 0 {
            return true;
        }
        for (to, from) in
            matrix.chunks_exact_mut(stride).zip(self.own.matrix.as_slice().chunks_exact(size))
        {
            to[..size].copy_from_slice(from);
        }
        let masses = self.own.points.iter().flat_map(|&point| [masses[point]; 3]);
        let positive = Arch::new().dispatch(AddMasses {
            matrix: &mut matrix,
            stride,
            masses: masses.collect(),
        });
        self.weighted = if exact {
            Weighted::Double(matrix)
        } else {
            #[expect(clippy::cast_possible_truncation, reason = "that is what it is for")]
            Weighted::Single(matrix.into_iter().map(|x| x as f32).collect())
        };
        positive
    }

    /// Writes the velocities that impulses cause, both by point.
    pub(super) fn respond(&self, impulses: &[Vector3<f64>], velocities: &mut [Vector3<f64>]) {
        for (i, &point) in self.own.points.iter().enumerate() {
            let mut velocity = Vector3::zeros();
            for (j, &other) in self.own.points.iter().enumerate() {
                velocity += self.own.matrix.fixed_view::<3, 3>(3 * i, 3 * j) * impulses[other];
            }
            velocities[point] = velocity;
        }
    }

    /// The traces of the blocks of each point with itself, by point.
    pub(super) fn traces(&self, traces: &mut [f64]) {
        for (i, &point) in self.own.points.iter().enumerate() {
            traces[point] = self.own.matrix.fixed_view::<3, 3>(3 * i, 3 * i).trace();
        }
    }
}

/// Takes the rows of a matrix after one mass after another was added.
struct AddMasses<'a> {
    matrix: &'a mut [f64],
    stride: usize,
    masses: Vec<f64>,
}

impl NullaryFnOnce for AddMasses<'_> {
    type Output = bool;

    #[inline(always)]
    fn call(self) -> bool {
        let mut column = vec![0.0; self.stride];
        for (i, &mass) in self.masses.iter().enumerate() {
            column.copy_from_slice(&self.matrix[i * self.stride..(i + 1) * self.stride]);
            let pivot = 1.0 + mass * column[i];
            if pivot <= 0.0 {
                return false;
            }
            let share = mass / pivot;
            for (to, x) in self.matrix.chunks_exact_mut(self.stride).zip(&column) {
                let factor = share * x;
                to.iter_mut().zip(&column).for_each(|(y, a)| *y -= factor * a);
            }
        }
        true
    }
}

/// Replaces impulses on points by the velocities that they cause with masses added, fibre by fibre.
pub(super) struct Answer<'a> {
    pub(super) explicit: &'a [Explicit],
    pub(super) impulses: &'a [Vector3<f64>],
    pub(super) velocities: &'a mut [Vector3<f64>],
}

impl NullaryFnOnce for Answer<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (mut single, mut double) = (Room::default(), Room::default());
        for Explicit { own, weighted, stride } in self.explicit {
            match weighted {
                Weighted::Single(matrix) => {
                    single.multiply(matrix, *stride, own, self.impulses, self.velocities);
                }
                Weighted::Double(matrix) => {
                    double.multiply(matrix, *stride, own, self.impulses, self.velocities);
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
    fn multiply(
        &mut self,
        matrix: &[T],
        stride: usize,
        own: &PointResponses,
        impulses: &[Vector3<f64>],
        velocities: &mut [Vector3<f64>],
    ) {
        self.from.clear();
        for &point in &own.points {
            self.from.extend(impulses[point].iter().map(|&x| convert::<f64, T>(x)));
        }
        self.to.clear();
        self.to.resize(stride, T::zero());
        let whole = matrix.chunks_exact(COLUMNS * stride);
        let rest = whole.remainder();
        let (fours, one_by_one) = self.from.as_chunks::<COLUMNS>();
        for (columns, [x, y, z, w]) in whole.zip(fours) {
            let (a, columns) = columns.split_at(stride);
            let (b, columns) = columns.split_at(stride);
            let (c, d) = columns.split_at(stride);
            for ((((to, a), b), c), d) in self.to.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                *to += (*a * *x + *b * *y) + (*c * *z + *d * *w);
            }
        }
        for (column, x) in rest.chunks_exact(stride).zip(one_by_one) {
            self.to.iter_mut().zip(column).for_each(|(to, a)| *to += *a * *x);
        }
        for (&point, to) in own.points.iter().zip(self.to.as_chunks::<3>().0) {
            velocities[point] = Vector3::from(*to).map(convert_unchecked::<T, f64>);
        }
    }
}
