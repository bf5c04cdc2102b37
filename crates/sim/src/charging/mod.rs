//! Fibres on which charge comes, at rest: chapter 4 of the thesis.

mod anderson;
mod electric;
mod flow;
mod head;
mod report;
mod rods;
mod settle;
mod stepper;

pub(crate) use electric::Electric;
pub use report::ChargeReport;
pub(crate) use rods::Resting;
pub(crate) use settle::{relax, set_matter};
pub(crate) use stepper::Charged;
