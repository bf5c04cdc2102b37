//! Where hair is already, in voxels (thesis 5.3.4).

mod boxes;
mod frame;
mod histogram;
mod term;
mod walk;

pub use frame::VoxelFrame;
pub use histogram::DensityHistogram;
pub use term::{DensityModel, HairDensity};
