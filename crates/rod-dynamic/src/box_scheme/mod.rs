//! The box scheme.

mod coefficients;
mod elimination;
mod ends;
mod integrator;
mod motion;
mod newton;
mod setup;
mod span;
mod stage;
mod state;
mod units;
mod update;

pub use coefficients::Coefficients;
pub use integrator::{BoxIntegrator, BoxOptions};
