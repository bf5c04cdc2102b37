//! The program as its users meet it.

mod common;
mod faults;
mod interruptions;
mod lab;
mod reading;
mod solve;
