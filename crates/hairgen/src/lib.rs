#![doc = include_str!("../README.md")]

mod cut;
mod density;
mod error;
mod guide;
mod near;
mod pore;
mod quadrature;
mod region;
mod report;
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
pub use wisp::{HairCurves, HairOptions, HairPattern, grow_hairs};
