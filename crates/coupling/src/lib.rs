#![doc = include_str!("../README.md")]

mod batch;
mod conditions;
mod contact;
mod contact_point;
mod error;
mod fibers;
mod free_body;
mod group;
mod ledger;
mod object;
mod pair;
mod report;
mod surroundings;

pub use batch::{RodBatch, Rods};
pub use conditions::{BundleConditions, FiberConditions};
pub use contact::{
    ActiveContact, ContactReport, ContactTimes, ContactWork, FibersInContact, Stopwatch, Unresolved,
};
pub use contact_point::BodyRef;
pub use error::CouplingError;
pub use fibers::Fibers;
pub use free_body::FreeBody;
pub use group::FiberGroup;
pub use ledger::EnergyLedger;
pub use object::{CollisionObject, Field, ObjectGeometry, ObjectMotion, extents};
pub use report::StepReport;
pub use surroundings::Surroundings;
