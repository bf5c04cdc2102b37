//! Scenes, the `Stepper` trait, observers and checkpoints.

pub mod export;
