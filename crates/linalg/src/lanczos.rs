//! Lanczos's method.

use crate::LinalgError;
use nalgebra::DVector;
use std::iter::once;

/// Most products.
const PRODUCTS: usize = 300;
/// Products between two looks at the eigenvalue.
const LOOK: usize = 20;
/// A change between two looks, in parts of the eigenvalue, that is none.
const CHANGE: f64 = 1e-7;
/// A vector shorter than this part of the largest is none.
const ROUNDING: f64 = 1e-12;

/// The largest eigenvalue of a symmetric matrix that is known by its product: `apply(z, y)` writes
/// `y = A z`. The vector `start` must have a part in the direction that is sought; a vector of
/// zeros gives zero.
///
/// It is never above the true one but for rounding, and below by a part in `1e6` or less where the
/// largest eigenvalues do not lie closer than that; it is given when it no longer changes, at the
/// latest after 300 products. Memory: three vectors.
///
/// # Errors
/// [`LinalgError::NotFinite`] if a product is not finite.
///
/// ```
/// use nalgebra::dvector;
/// use rapunzel_linalg::largest_eigenvalue;
///
/// let largest = largest_eigenvalue(dvector![1.0, 2.0, 0.5], |z, y| {
///     *y = dvector![2.0 * z[0], -7.0 * z[1], 3.0 * z[2]];
/// })?;
/// assert!((largest - 3.0).abs() < 1e-12);
/// # Ok::<(), rapunzel_linalg::LinalgError>(())
/// ```
pub fn largest_eigenvalue(
    start: DVector<f64>,
    mut apply: impl FnMut(&DVector<f64>, &mut DVector<f64>),
) -> Result<f64, LinalgError> {
    let mut vector = start;
    let norm = vector.norm();
    if norm == 0.0 {
        return Ok(0.0);
    }
    vector /= norm;
    let mut before = DVector::zeros(vector.len());
    let mut image = before.clone();
    let (mut diagonal, mut beside) = (Vec::<f64>::new(), Vec::<f64>::new());
    let (mut scale, mut largest) = (0.0_f64, f64::NEG_INFINITY);
    for product in 1..=PRODUCTS {
        apply(&vector, &mut image);
        let along = image.dot(&vector);
        image.axpy(-along, &vector, 1.0);
        if let Some(&last) = beside.last() {
            image.axpy(-last, &before, 1.0);
        }
        let rest = image.norm();
        if !(along.is_finite() && rest.is_finite()) {
            return Err(LinalgError::NotFinite { what: "product" });
        }
        diagonal.push(along);
        scale = scale.max(along.abs() + rest);
        let all = rest <= ROUNDING * scale;
        if all || product % LOOK == 0 {
            let value = largest_of_tridiagonal(&diagonal, &beside);
            if all || value - largest <= CHANGE * value.abs() {
                return Ok(value);
            }
            largest = value;
        }
        beside.push(rest);
        std::mem::swap(&mut before, &mut vector);
        std::mem::swap(&mut vector, &mut image);
        vector /= rest;
    }
    Ok(largest)
}

/// By bisection, to rounding: above the largest eigenvalue and nowhere else all pivots of
/// `T - x` are negative.
fn largest_of_tridiagonal(diagonal: &[f64], beside: &[f64]) -> f64 {
    let above = |x: f64| {
        let mut pivot = -1.0;
        diagonal.iter().zip(once(&0.0).chain(beside)).all(|(d, b)| {
            pivot = d - x - b * b / pivot;
            pivot < 0.0
        })
    };
    let mut low = diagonal.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let widest = beside.iter().copied().fold(0.0, f64::max);
    let mut high = low + 2.0 * widest;
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if above(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
}
