#![doc = include_str!("../README.md")]

mod adhesion;
mod admm;
mod answers;
mod body;
pub mod chain;
mod contact;
mod error;
mod gauss_seidel;
mod impact;
mod limit_curve;
mod local;
mod metric;
mod polished;
pub mod projection;
mod residual;
mod response;
pub mod rigid;
mod solver;

pub use adhesion::{Bond, Cylinders, wet_pair_energy};
pub use admm::Admm;
pub use answers::{Answer, DelassusBlocks, Eight};
pub use body::Body;
pub use contact::Contact;
pub use error::ContactError;
pub use gauss_seidel::GaussSeidel;
pub use impact::{ImpactReport, closing, impact, impact_in_turn};
pub use limit_curve::{Friction, LimitCurve, Polygon};
pub use local::solve_contact;
pub use polished::Polished;
pub use residual::{Violation, report};
pub use response::Response;
pub use rigid::{RigidBody, RigidPoints};
pub use solver::{Report, Solver, Tolerance};
