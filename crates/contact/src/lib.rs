#![doc = include_str!("../README.md")]

mod adaptive;
mod adhesion;
mod admm;
mod body;
mod contact;
mod contact_solver;
mod delassus_blocks;
mod error;
mod free_masses;
mod gauss_seidel;
mod impact;
mod limit_curve;
mod local;
mod metric;
mod polished;
mod residual;
pub mod rigid;
mod solver;
pub mod thesis;

pub use adaptive::Adaptive;
pub use adhesion::{Bond, Cylinders, wet_pair_energy};
pub use admm::Admm;
pub use body::Body;
pub use contact::Contact;
pub use contact_solver::ContactSolver;
pub use delassus_blocks::{DelassusBlocks, UnitResponse, VectorLanes};
pub use error::ContactError;
pub use free_masses::FreeMasses;
pub use gauss_seidel::GaussSeidel;
pub use impact::{ImpactReport, closing, impact, impact_in_turn};
pub use limit_curve::{Friction, LimitCurve, Polygon};
pub use local::solve_contact;
pub use polished::Polished;
pub use residual::{ErrorMasses, Violation, report};
pub use rigid::{RigidBody, RigidPoints};
pub use solver::{Report, Solver, Tolerance};
