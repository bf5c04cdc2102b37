//! The methods of the thesis (Sobottka 2009) for rigid bodies, kept to compare with.
//!
//! What a user runs are the solvers at the root of the crate. Here are, with every printed error as
//! a switch, Moreau's time stepping by two projections of the velocities ([`projection`], Alg. 6)
//! and fibers as rigid cylinders joined by impulses ([`chain`], section 8.5).

pub mod chain;
pub mod projection;
mod response;

pub use response::Response;
