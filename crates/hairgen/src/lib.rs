#![doc = include_str!("../README.md")]

mod cut;
mod density;
mod error;
pub mod fit;
pub mod growth;
mod guide;
pub mod head;
mod near;
mod pore;
mod quadrature;
mod region;
mod report;
pub mod style;
mod surface;
pub mod thesis;
mod wisp;

pub use cut::cut;
pub use density::{DensityHistogram, DensityModel, HairDensity, VoxelFrame};
pub use error::HairgenError;
pub use guide::{
    EndLoad, GuideHair, GuideHairs, GuideOptions, GuideWeights, PreGuide, Terms, dips_by_height,
    grow_pre_guides, place_guides,
};
pub use pore::Pore;
pub use region::Region;
pub use report::HairReport;
pub use surface::{FieldResolution, SurfaceField};
pub use wisp::{Curl, CurlShape, HairCurves, HairOptions, HairPattern, grow_hairs};
