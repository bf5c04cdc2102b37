//! What is told while a world is built.

use crate::style::GrowthStage;

/// A part of the building of a world that takes long.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BuildStage {
    /// The style of a bundle grows.
    Growing {
        /// Number of the bundle in the scene.
        bundle: usize,
        /// Part of the growth that begins.
        stage: GrowthStage,
    },
    /// Groomed fibres are moved out of what they overlap.
    MovingApart,
    /// Groomed fibres in contact settle, or those that are wound around objects.
    Settling {
        /// Number of the step that begins.
        done: usize,
        /// Number of steps at most.
        most: usize,
    },
}
