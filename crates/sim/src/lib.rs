#![doc = include_str!("../README.md")]

mod assemble;
mod case_error;
mod checkpoint;
mod curve;
mod energy;
mod error;
mod estimate;
mod file;
mod folder;
mod folder_lock;
mod hands;
mod kept;
pub mod lab;
mod manifest;
mod mass_spring;
mod objects;
mod observers;
mod run;
mod shown;
pub mod statics;
mod stepper;
mod steppers;
mod storage;
pub mod style;
mod summary;
mod touches;
mod volumes;
mod world;

pub use assemble::BuildStage;
pub use error::SimError;
pub use estimate::{MemoryEstimate, MemoryShare};
pub use file::read_text;
pub use folder::{Existing, RunFolder, claim};
pub use folder_lock::in_use;
pub use kept::{keep_state, take_up_state};
pub use rapunzel_charging::{ChargeReport, ChargingError};
pub use rapunzel_coupling::{
    ActiveContact, BodyRef, ContactReport, ContactTimes, ContactWork, CouplingError, EnergyLedger,
    StepReport, Stopwatch, Surroundings, Unresolved,
};
pub use rapunzel_scene::{self as scene, Plan, Scene};
pub use run::{Cancel, Control, Progress, run};
pub use shown::{Shown, ShownFrame, ShownStage};
pub use stepper::{ContactForce, FiberStates, NodePull, Scenery, Stepper};
pub use storage::write_atomically;
pub use summary::{LeftOut, Outcome, Statistics, Summary};
pub use volumes::bounding_boxes;
pub use world::{Snapshot, World};
