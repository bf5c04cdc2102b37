#![doc = include_str!("../README.md")]

mod batch;
mod conditions;
mod contact;
mod error;
mod fibers;
mod free_body;
mod group;
mod ledger;
mod object;
mod pair;
mod report;
mod surroundings;
mod touch;

pub use batch::{Batch, Rods};
pub use conditions::{BundleConditions, FiberConditions};
pub use contact::{
    Bearing, ContactReport, ContactTimes, ContactWork, FibersInContact, Stopwatch, Unresolved,
};
pub use error::CouplingError;
pub use fibers::Fibers;
pub use free_body::FreeBody;
pub use group::Group;
pub use ledger::EnergyLedger;
pub use object::{Field, Geometry, Object, ObjectMotion, extents};
pub use report::StepReport;
pub use surroundings::Surroundings;
pub use touch::Partner;
