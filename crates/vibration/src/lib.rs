#![doc = include_str!("../README.md")]

mod dense;
mod error;
mod lanczos;

pub use dense::{Modes, characteristic_exponents, eigen, modes, smallest_eigenvalue};
pub use error::VibrationError;
pub use lanczos::largest_eigenvalue;
