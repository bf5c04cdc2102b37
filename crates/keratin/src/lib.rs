#![doc = include_str!("../README.md")]

mod climate;
mod error;
mod hair;
pub mod lab;
pub mod law;
pub mod moduli;
pub mod surface;
pub mod tables;
pub mod water;

#[doc = include_str!("../data/inconsistencies.md")]
pub mod inconsistencies {}

pub use climate::{
    Climate, Humidity, MeasuredValue, Outside, SorptionBranch, Standing, Temperature,
};
pub use error::KeratinError;
pub use hair::{Growth, Hair, HairType, Sex, Thickness, Treatment, follicle_density};
