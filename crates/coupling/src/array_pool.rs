//! Large arrays that are used again and again within a step. What is freed instead goes back to the
//! system, and every page of it must be made anew.

use std::ops::{Deref, DerefMut};
use std::sync::{Arc, Mutex, PoisonError};

/// Arrays that are free to be used.
#[derive(Debug)]
pub(crate) struct ArrayPool<T>(Arc<Mutex<Vec<Vec<T>>>>);

/// An array that goes back to its pool when it is dropped.
#[derive(Debug)]
pub(crate) struct PooledArray<T> {
    array: Vec<T>,
    pool: ArrayPool<T>,
}

impl<T> Default for ArrayPool<T> {
    fn default() -> Self {
        Self(Arc::default())
    }
}

impl<T: Clone> ArrayPool<T> {
    /// An array of a length, with values of before, or with `value`.
    pub(crate) fn take(&self, length: usize, value: T) -> PooledArray<T> {
        let free = self.0.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut array = free.unwrap_or_default();
        array.resize(length, value);
        PooledArray { array, pool: Self(Arc::clone(&self.0)) }
    }
}

impl<T> Drop for PooledArray<T> {
    fn drop(&mut self) {
        let array = std::mem::take(&mut self.array);
        self.pool.0.lock().unwrap_or_else(PoisonError::into_inner).push(array);
    }
}

impl<T> Deref for PooledArray<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        &self.array
    }
}

impl<T> DerefMut for PooledArray<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.array
    }
}
