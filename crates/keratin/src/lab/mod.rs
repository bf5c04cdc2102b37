//! The instruments of chapter 2: what they read, as numbers, and the fibres that are put in.
//!
//! Each module is one instrument. It evaluates readings by the formula of the thesis, with the bias
//! of that formula where it has one, and builds the fibre for a simulation that gives the readings.
//! What moves the fibre is another crate's business; the tests of this crate do it with rods at rest
//! and in motion. Capstan friction and combing need contacts and are not here.

pub mod curl;
pub mod hook;
pub mod oscillation;
pub mod pendulum;
pub mod tensile;
pub mod tress;
