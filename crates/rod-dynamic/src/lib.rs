//! Motion of one inextensible, unshearable Cosserat rod, and of many at once.
//!
//! Two integrators of the same rod stand behind [`RodIntegrator`] and check each other:
//! the box scheme of the thesis (3.4), and the staggered chain.
//!
//! Positions, velocities and forces are in the world frame; curvature, angular velocity and
//! moments are in the material frame `R = [d1 d2 d3]`, d3 the tangent. SI units.

pub mod adaptive;
pub mod box_scheme;
mod conditions;
mod error;
mod response;
mod rod;
mod staggered;

pub use adaptive::AdaptiveReport;
pub use box_scheme::{BoxIntegrator, BoxOptions, Coefficients};
pub use conditions::{Air, Conditions, Drag, End, Instant, Load, Steady};
pub use error::{RodError, StepError};
pub use response::{ImpulseResponse, Weight};
pub use rod::{Energy, Rod, RodIntegrator, RodState, StepReport};
pub use staggered::{EquilibriumError, Staggered, StaggeredBatch, equilibrium};
