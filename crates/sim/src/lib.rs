//! Scenes, the `Stepper` trait, observers and checkpoints.

mod error;
pub mod scene;

pub use error::SimError;
