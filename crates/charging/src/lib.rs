#![doc = include_str!("../README.md")]

mod anderson;
mod charged;
mod electric;
mod error;
mod fibers;
mod flow;
mod head;
mod report;
mod rods;
mod settle;

pub use charged::ChargedRods;
pub use error::ChargingError;
pub use head::HeadGeometry;
pub use report::ChargeReport;
