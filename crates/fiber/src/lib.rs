#![doc = include_str!("../README.md")]

mod assembly;
mod error;
pub mod euler;
mod fiber;
pub mod generate;
mod law;
mod layout;
pub mod quadrature;
pub mod quaternion;
pub mod se3;
mod section;
pub mod so3;
pub mod spline;

pub use assembly::{Assembly, GROUP_SIZE};
pub use error::FiberError;
pub use fiber::{Fiber, Material, NodeProperties};
pub use law::{LinearLaw, SectionLaw, SectionResponse};
pub use layout::Layout;
pub use section::Section;
