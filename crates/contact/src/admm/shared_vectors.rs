//! Vectors that all parts read and each writes some of.
use nalgebra::Vector3;
use std::array::from_fn;
use std::sync::atomic::{AtomicU64, Ordering};

/// Vectors shared by all threads of a pool: what is written in one phase may be read in the next.
/// Loads and stores that need no order cost what plain ones do.
pub(super) struct SharedVectors(Vec<[AtomicU64; 3]>);

impl SharedVectors {
    /// `count` vectors, all zero, and one more that stands for absent sides and points.
    ///
    /// Made by the calling thread alone: within a lazy value a thread that waits for others may be
    /// given work that needs the same value, and then both wait for ever.
    pub(super) fn zeros(count: usize) -> Self {
        let zero = || from_fn(|_| AtomicU64::new(0.0_f64.to_bits()));
        Self(std::iter::repeat_with(zero).take(count + 1).collect())
    }

    /// Vector number `i`.
    #[inline]
    pub(super) fn get(&self, i: usize) -> Vector3<f64> {
        let [x, y, z] = &self.0[i];
        let number = |x: &AtomicU64| f64::from_bits(x.load(Ordering::Relaxed));
        Vector3::new(number(x), number(y), number(z))
    }

    /// Writes vector number `i`.
    #[inline]
    pub(super) fn set(&self, i: usize, v: &Vector3<f64>) {
        self.0[i].iter().zip(v).for_each(|(x, v)| x.store(v.to_bits(), Ordering::Relaxed));
    }
}
