#![doc = include_str!("../README.md")]

mod canvas;
mod coloring;
mod error;
mod font;
mod legend;
mod look;
pub mod sheet;
mod stage;

pub use coloring::{ColorRange, Coloring};
pub use error::StudioError;
pub use legend::write_with_legend;
pub use look::{HairLook, HairModel, pigments};
pub use stage::{StageOptions, camera_around, hull, points, staged};
