//! Where hair grows (thesis 5.3.2).
//!
//! A scalp ([`ScalpMesh`]) is mapped one-to-one to the unit disc ([`DiscMap`]), where density,
//! length and direction of its hair are numbers, functions or grey images ([`DiscField`]). A
//! [`GrowthRegion`] is all of it; it places pores.

mod axes;
mod blue_noise;
mod direction;
mod disc_map;
mod elimination;
mod field;
mod geodesic;
mod image;
mod mass;
mod neighbors;
mod region;
mod rings;
mod scalp;
mod stretch;
mod surface_point;
mod weights;

pub use axes::HeadAxes;
pub use direction::{GrowthFlow, Whorl};
pub use disc_map::{DiscMap, convex_map};
pub use field::{DiscField, DiscFunction};
pub use geodesic::{geodesic_distances, surface_gradient};
pub use image::GreyImage;
pub(crate) use mass::MOST_DENSITY;
pub(crate) use region::LENGTHS;
pub use region::{DENSE_DENSITY, GrowthOptions, GrowthRegion, SPARSE_DENSITY};
pub use scalp::ScalpMesh;
pub use surface_point::SurfacePoint;
pub use weights::ConvexWeights;
