//! The thesis's own ways where better ones have taken their place, for its figures.

mod simplex;

pub use simplex::{SimplexGuide, simplex_guides};
