#![doc = include_str!("../README.md")]

mod error;
pub mod fit;
pub mod growth;
pub mod head;
mod pore;
mod region;
mod surface;

pub use error::HairgenError;
pub use pore::Pore;
pub use region::AdmissibleRegion;
pub use surface::{FieldResolution, SurfaceField};
