//! Both integrators of a moving rod, against exact solutions and each other.

#![expect(clippy::print_stdout, reason = "tests tell what they measured")]

mod adaptive;
mod allocations;
mod box_conservation;
mod box_ends;
mod box_frequencies;
mod box_order;
mod box_robust;
mod box_statics;
mod box_swing;
mod common;
mod linear_frequencies;
mod linear_stability;
mod natural;
mod nozzle;
mod properties;
mod staggered_agreement;
mod staggered_arms;
mod staggered_batch;
mod staggered_clamped;
mod staggered_conservation;
mod staggered_flight;
mod staggered_increments;
mod staggered_laws;
mod staggered_ledger;
mod staggered_order;
mod staggered_response;
mod staggered_robust;
mod staggered_spin;
mod staggered_statics;
mod staggered_swing;
mod supported_ends;
mod supported_response;
