//! Tests of the readers and of what is done with strands.

mod chains;
mod common;
mod damaged;
mod ponytail;
mod resample;
mod round_trip;
mod scalp;
mod sorted;
mod usd;
mod usd_curves;
mod usdc;
