//! Guides: few hairs that are laid by forces and couples on their ends into the region between
//! head and hull (thesis 5.3.3), and that all others follow.

mod flow;
mod hang;
mod objective;
mod options;
mod place;
mod pre;
mod pre_guide;
mod rod;
mod search;
mod terms;

pub use objective::Terms;
pub use options::{GuideOptions, GuideWeights};
pub use place::{GuideHair, GuideHairs, place_guides};
pub use pre::{dips_by_height, grow_pre_guides};
pub use pre_guide::PreGuide;
pub use rod::EndLoad;

pub(crate) use flow::GuideFlow;
pub(crate) use objective::Objective;
pub(crate) use rod::GuideRod;
