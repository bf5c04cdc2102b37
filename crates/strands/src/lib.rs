#![doc = include_str!("../README.md")]

mod bytes;
mod chains;
mod data;
mod error;
mod file;
mod hair;
mod obj;
mod options;
mod ply;
mod raw;
mod report;
mod resample;
mod scalp;
mod set;
mod usd;

pub use error::StrandsError;
pub use file::{StrandFile, StrandFormat};
pub use options::ReadOptions;
pub use report::{Known, Origin, StrandFault, StrandReport, UpAxis};
pub use resample::Resampled;
pub use scalp::Snapped;
pub use set::StrandSet;
