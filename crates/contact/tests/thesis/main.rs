//! The thesis's own method: rigid bodies, Alg. 6, chains and Alg. 7.
#![expect(clippy::print_stdout, reason = "figures of what is printed wrong")]

mod chain;
mod chain_defects;
mod chains;
mod common;
mod harmonize;
#[path = "../common/incline.rs"]
mod incline;
mod projection;
mod projection_defects;
mod projection_oracle;
mod projection_solver;
mod rigid;
