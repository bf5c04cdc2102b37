//! The laws of contact: limit curves, one contact, many contacts, impacts, adhesion, rigid
//! bodies.

mod adaptive;
mod adhesion;
mod admm;
mod beams;
mod between;
mod curves;
mod impacts;
mod local;
mod oracles;
mod piles;
mod polished;
mod rigid;
mod rope;
mod slopes;
mod solver;
