#![doc = include_str!("../README.md")]

mod admm;
mod anderson;
mod body;
mod contact;
mod error;
mod limit_curve;
mod solver;

pub use admm::{Admm, Tolerance};
pub use body::Body;
pub use contact::Contact;
pub use error::ContactError;
pub use limit_curve::LimitCurve;
pub use solver::{Certificate, Report, Solver};
