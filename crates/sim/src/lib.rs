//! Scenes, the `Stepper` trait, observers and checkpoints.
