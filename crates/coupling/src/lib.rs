#![doc = include_str!("../README.md")]

mod array_pool;
mod batch;
mod body_ref;
mod conditions;
mod contact;
mod contact_point;
mod contact_report;
mod error;
mod fiber_on_object;
mod fibers;
mod free_body;
mod group;
mod held_places;
mod joints;
mod known_values;
mod ledger;
mod merging;
mod object;
mod pair;
mod phase_times;
mod regrouping;
mod report;
mod surroundings;
mod time_interval;

pub use batch::{RodBatch, Rods};
pub use body_ref::BodyRef;
pub use conditions::{BundleConditions, FiberConditions};
pub use contact::{
    ActiveContact, BallJoint, ContactJoints, ContactWork, FibersInContact, Separation, separate,
};
pub use contact_report::{ContactReport, Unresolved};
pub use error::CouplingError;
pub use fibers::Fibers;
pub use free_body::FreeBody;
pub use group::FiberGroup;
pub use joints::{Connection, FiberPlace, JoinedFibers, NodeJoint};
pub use ledger::EnergyLedger;
pub use object::{CollisionObject, Field, ObjectGeometry, ObjectMotion, extents};
pub use phase_times::{ContactTimes, Stopwatch};
pub use report::StepReport;
pub use surroundings::Surroundings;
pub use time_interval::TimeInterval;
