#![doc = include_str!("../README.md")]

mod body;
pub mod chain;

mod contact;
mod error;
mod limit_curve;
pub mod projection;
pub mod rigid;
mod solver;

pub use body::Body;
pub use contact::Contact;
pub use error::ContactError;
pub use limit_curve::LimitCurve;
pub use rigid::{RigidBody, RigidPoints};
pub use solver::{Report, Solver};
