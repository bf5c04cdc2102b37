#![doc = include_str!("../README.md")]

mod assemble;
mod charging;
mod checkpoint;
mod conditions;
mod contact;
mod curve;
mod energy;
mod error;
mod estimate;
mod file;
mod folder;
mod group;
pub mod lab;
mod manifest;
mod mass_spring;
mod observers;
mod run;
pub mod statics;
mod stepper;
mod storage;
mod summary;
mod works;
mod world;

pub use assemble::stepper_for;
pub use charging::ChargeReport;
pub use contact::{
    Bearing, ContactReport, ContactTimes, ContactWork, Partner, Stopwatch, Unresolved,
};
pub use error::SimError;
pub use estimate::{Estimate, Part};
pub use file::read_text;
pub use folder::{Existing, RunFolder, claim, in_use};
pub use mass_spring::MassSprings;
pub use rapunzel_scene::{self as scene, Plan, Scene};
pub use run::{Cancel, Control, Progress, run};
pub use stepper::{FreeFibers, StepReport, Stepper};
pub use storage::write_atomically;
pub use summary::{LeftOut, Outcome, Statistics, Summary};
pub use works::Works;
pub use world::{Snapshot, World};
