use nalgebra::SVector;
use std::ops::Range;

/// Vectors of dimension `D`, stored component by component, so that loops over neighbors run in
/// SIMD lanes.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeVectors<const D: usize>(pub(crate) [Vec<f64>; D]);

/// `2^400`: values of this size have no meaning in a simulation, and their squares soon overflow.
pub(crate) const BEYOND: f64 = f64::from_bits((1023 + 400) << 52);

impl<const D: usize> Default for NodeVectors<D> {
    fn default() -> Self {
        Self::zeros(0)
    }
}

impl<const D: usize> NodeVectors<D> {
    /// `count` vectors of zeros.
    #[must_use]
    pub fn zeros(count: usize) -> Self {
        Self(std::array::from_fn(|_| vec![0.0; count]))
    }

    /// Converts a list of vectors to columns.
    #[must_use]
    pub fn of(vectors: &[SVector<f64, D>]) -> Self {
        Self(std::array::from_fn(|axis| vectors.iter().map(|v| v[axis]).collect()))
    }

    /// Number of vectors.
    #[must_use]
    pub fn len(&self) -> usize {
        self.0.first().map_or(0, Vec::len)
    }

    /// Whether there are no vectors.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Vector `i`.
    ///
    /// # Panics
    /// If there is no such vector, as indexing does.
    #[must_use]
    pub fn get(&self, i: usize) -> SVector<f64, D> {
        SVector::from_fn(|axis, _| self.0[axis][i])
    }

    /// Sets vector `i`.
    ///
    /// # Panics
    /// If there is no such vector, as indexing does.
    pub fn set(&mut self, i: usize, value: &SVector<f64, D>) {
        for axis in 0..D {
            self.0[axis][i] = value[axis];
        }
    }

    /// Adds `value` to vector `i`.
    ///
    /// # Panics
    /// If there is no such vector, as indexing does.
    pub fn add(&mut self, i: usize, value: &SVector<f64, D>) {
        for axis in 0..D {
            self.0[axis][i] += value[axis];
        }
    }

    /// Sets all vectors to zero.
    pub(crate) fn clear(&mut self) {
        self.0.iter_mut().for_each(|column| column.fill(0.0));
    }

    /// Adds `factor * other` to all vectors.
    #[inline(always)]
    pub(crate) fn add_scaled(&mut self, factor: f64, other: &Self) {
        for (to, from) in self.0.iter_mut().zip(&other.0) {
            for (to, from) in to.iter_mut().zip(from) {
                *to += factor * from;
            }
        }
    }

    /// Sum of the products of all components with those of `other`, in a fixed order of partial
    /// sums, so that it runs in SIMD lanes.
    #[inline(always)]
    pub(crate) fn dot(&self, other: &Self) -> f64 {
        let mut sum = 0.0;
        for axis in 0..D {
            sum += summed(&self.0[axis], &other.0[axis], |a, b| a * b);
        }
        sum
    }

    /// Sum of the squares of all components times `weights`.
    #[inline(always)]
    pub(crate) fn dot_weighted(&self, weights: &Self) -> f64 {
        let mut sum = 0.0;
        for axis in 0..D {
            sum += summed(&self.0[axis], &weights.0[axis], |a, w| a * a * w);
        }
        sum
    }

    /// Largest absolute value of a component.
    pub(crate) fn largest(&self) -> f64 {
        self.0.iter().flatten().fold(0.0, |largest: f64, x| largest.max(x.abs()))
    }

    /// Index of the first vector in a range with a component beyond [`BEYOND`].
    pub(crate) fn first_beyond(&self, mut vectors: Range<usize>) -> Option<usize> {
        let sound = |column: &Vec<f64>, i: usize| column[i].abs() < BEYOND;
        vectors.find(|&i| !self.0.iter().all(|column| sound(column, i)))
    }

    /// Index of the first vector that is not finite.
    pub(crate) fn first_not_finite(&self) -> Option<usize> {
        (0..self.len()).find(|&i| self.0.iter().any(|column| !column[i].is_finite()))
    }
}

#[inline(always)]
fn summed(a: &[f64], b: &[f64], term: impl Fn(f64, f64) -> f64) -> f64 {
    let mut sums = [0.0; 16];
    let (a, a_rest) = a.as_chunks::<16>();
    let (b, b_rest) = b.as_chunks::<16>();
    for (a, b) in a.iter().zip(b) {
        for lane in 0..16 {
            sums[lane] += term(a[lane], b[lane]);
        }
    }
    for (sum, (a, b)) in sums.iter_mut().zip(a_rest.iter().zip(b_rest)) {
        *sum += term(*a, *b);
    }
    sums.iter().sum()
}
