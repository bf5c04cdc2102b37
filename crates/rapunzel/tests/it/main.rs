//! The program as its users meet it.

mod common;
mod faults;
mod grow;
mod interruptions;
mod lab;
mod reading;
mod render;
mod solve;
