//! The thesis's own method: rigid bodies, Alg. 6, chains and Alg. 7.
mod chain;
mod chain_defects;
mod chains;
mod common;
mod harmonize;
mod projection;
mod projection_defects;
mod projection_oracle;
mod projection_solver;
mod rigid;
