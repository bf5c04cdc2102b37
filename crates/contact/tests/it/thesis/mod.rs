//! The thesis's own method: Alg. 6 with rigid bodies and as a solver, chains and Alg. 7.
mod chain;
mod chain_defects;
mod chains;
mod common;
mod harmonize;
mod projection;
mod projection_defects;
mod projection_oracle;
mod projection_solver;
mod two_projections;
