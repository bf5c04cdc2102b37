//! The staggered rod: a chain of rigid segments in the world frame.
//!
//! Nodes carry mass, segments carry a material frame and the force that keeps their length, and
//! joints at the nodes carry the bending and torsion of what lies between the middles of their
//! segments. Segment lengths and momentum hold to rounding at all times.
//!
//! Compared with the box scheme: in the world frame, symmetric, without pivoting, several times
//! cheaper, and with a potential energy to minimise in each step, which makes it robust; its time
//! error is larger. It is the default for assemblies.
//!
//! A batch stores only the state of its fibres; batches of equal fibres share one model, and each
//! thread has one workspace for solves, which the batches borrow in turn.
//!
//! [`StaggeredBatch`] moves up to eight fibres in SIMD lanes; [`Staggered`] is a batch of one
//! behind [`crate::RodIntegrator`]. The motion of a fibre does not depend on the others in its
//! batch, bit for bit.

mod answers;
mod array;
mod attempt;
mod batch;
mod batch_step;
mod chain;
mod check;
mod coupled;
mod coupled_step;
mod ends;
mod equilibrium;
mod erased_batch;
mod exchange;
mod factor;
mod fed_segments;
mod history;
mod impulse_columns;
mod impulses;
mod inputs;
mod joined_step;
mod joint_geometry;
mod joint_loads;
mod joints;
mod laws;
mod ledger;
mod ledger_ends;
mod ledger_lanes;
mod memory;
mod model;
mod natural;
mod newton;
mod nozzle;
mod outset;
mod point_places;
mod readout;
mod response;
mod scheme;
mod search;
mod simd_batch;
mod single;
mod spin;
mod stability;
mod supported_ends;
mod supports;
mod velocities;
mod velocity_lanes;
mod workspace;

pub use batch::StaggeredBatch;
pub use equilibrium::{EquilibriumError, equilibrium};
pub use exchange::MovingRod;
pub use natural::{
    FittedFiber, bounded_natural_curvatures, fitted, fitted_end_load, natural_curvatures,
};
pub use nozzle::segments_in_nozzle;
pub use search::expected_error;
pub use single::Staggered;
pub use velocity_lanes::StepVelocity;
