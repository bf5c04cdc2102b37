//! Rope, net and bodies, against exact solutions and ledgers.

mod bodies;
mod common;
mod conservation;
mod contacts;
mod ledger;
mod oracles;
mod properties;
mod waves;
