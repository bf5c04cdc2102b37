//! The trees and volumes of the thesis (Sobottka 2009, chapter 7), kept to compare with.
//!
//! What a program runs is at the root of the crate, [`crate::Tree`] and [`crate::Candidates`],
//! which use nothing of this. Here are every tree ([`hierarchy`]) and volume ([`volume`], with the
//! directions of [`packing`]) that the thesis compares, and the arrangements of fibres ([`scenes`])
//! that all searches, also those at the root, are tested and timed with.

pub mod hierarchy;
pub mod packing;
pub mod scenes;
pub mod volume;
