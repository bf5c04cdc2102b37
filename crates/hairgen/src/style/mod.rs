//! A hairstyle from a file: what it says ([`Style`]), and what grows of it ([`Hairstyle`]).

mod check;
mod grow;
mod report;
mod room;
mod spec;
mod surfaces;

pub use grow::{GrowthStage, Hairstyle};
pub use report::StyleReport;
pub use spec::{FlowSpec, GuideSpec, HairSource, HeadSource, ScalpField, Style, Voxel};
pub use surfaces::{CrossedSurface, HullField, StyleSurfaces};
