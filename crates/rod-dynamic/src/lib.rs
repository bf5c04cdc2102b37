#![doc = include_str!("../README.md")]

pub mod adaptive;
pub mod box_scheme;
mod conditions;
mod error;
mod joint;
mod joint_load;
mod ledger;
#[cfg(feature = "modes")]
mod linear;
mod load;
mod moments;
mod node_quantity;
mod response;
mod rod;
mod staggered;
mod support;

pub use adaptive::AdaptiveReport;
pub use box_scheme::{BoxIntegrator, BoxOptions, Coefficients};
pub use conditions::{Air, Conditions, Drag, End, Instant, Steady};
pub use error::{RodError, StepError};
pub use joint::JointAction;
pub use joint_load::{JointLoads, LoadPlace, LoadPoint};
pub use ledger::Ledger;
#[cfg(feature = "modes")]
pub use linear::{Linearization, Mode, linearize};
pub use load::Load;
pub use moments::elastic_moments;
pub use node_quantity::NodeQuantity;
pub use response::{ImpulseResponse, Impulses, Point, PointAction, PointResponses};
pub use rod::{Energy, Momentum, Rod, RodIntegrator, RodState, RodStepReport, SectionLaws};
pub use staggered::{
    EquilibriumError, FittedFiber, MovingRod, Staggered, StaggeredBatch, StepVelocity,
    bounded_natural_curvatures, equilibrium, expected_error, fitted, fitted_end_load,
    natural_curvatures, segments_in_nozzle,
};
pub use support::{EndSupport, Restraint};
