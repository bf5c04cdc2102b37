//! Real solid harmonics and how they are moved.
//!
//! `R_nm(x) = r^n Y_nm`, with `Y_n0 = P_n(cos theta)` and, for `m > 0`,
//! `sqrt(2 (n-m)!/(n+m)!) P_n^m(cos theta)` times `cos(m phi)` or `sin(m phi)`, without the
//! Condon-Shortley sign. In this normalization
//! `1/|x - y| = sum_n |x|^n/|y|^(n+1) sum_m Y_nm(x) Y_nm(y)` for `|x| < |y|` (the thesis's (4.4) to
//! (4.8)), rotations are orthogonal matrices, and no number is larger than `r^n`. Lengths are
//! divided by the radius of the cell, so that no order overflows.

mod kernels;
mod products;
mod shift;
mod tables;
#[cfg(test)]
mod tests;
mod translate;
mod translation_tables;
mod turn;

pub(crate) use kernels::{Gradient, regular, regular_at};
pub(crate) use shift::{Shift, TranslationKind};
pub(crate) use tables::{HarmonicTables, count};
pub(crate) use translate::Translator;
pub(crate) use translation_tables::Coefficient;

/// The highest degree of an expansion.
pub const MAX_ORDER: usize = 40;
