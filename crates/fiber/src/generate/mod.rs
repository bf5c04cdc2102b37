//! Fibres of given rest shapes and many fibres over a patch of skin.
//!
//! A shape ([`Helix`], [`Sine`]) bends a fibre: it sets the natural curvature and turns the root,
//! and leaves lengths, sections and materials as they are. A straight fibre is
//! [`crate::Fiber::uniform`] at a [`root_pose`]; an [`Overhand`] knot, or any [`LongKnot`], gives
//! positions for the nodes of a straight fibre, and so do an [`OpenCurve`] and a fibre that is
//! [`Wound`]. An [`Ellipse`] places roots, [`bundle`] and [`Lock`] grow fibres from them.
//!
//! Random choices come from `Pcg64Mcg` with the seed that is given: the same seed gives the same
//! bits.

mod chords;
mod knot;
mod lock;
mod long_knot;
mod open_curve;
mod random;
mod roots;
mod shape;
mod wound;

pub use knot::Overhand;
pub use lock::{Lock, bundle};
pub use long_knot::LongKnot;
pub use open_curve::OpenCurve;
pub use roots::Ellipse;
pub use shape::{Handedness, Helix, Sine, root_pose};
pub use wound::Wound;
