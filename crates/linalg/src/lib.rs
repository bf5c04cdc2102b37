#![doc = include_str!("../README.md")]

#[cfg(feature = "dense")]
mod dense;
mod error;
mod lanczos;
#[cfg(feature = "sparse")]
mod sparse;

#[cfg(feature = "dense")]
pub use dense::{Modes, characteristic_exponents, eigen, modes, smallest_eigenvalue};
pub use error::LinalgError;
pub use lanczos::largest_eigenvalue;
#[cfg(feature = "sparse")]
pub use sparse::SparseSystem;
