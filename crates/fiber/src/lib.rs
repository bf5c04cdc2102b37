//! The ground floor of Rapunzel: rotations, cross sections, a fibre and an assembly of fibres.
//!
//! A fibre is a Cosserat rod in its natural state: a chain of rest lengths with, at every node, a
//! cross section, stiffnesses, inertia and a natural curvature, and one pose for its root. The
//! material frame `R = [d1 d2 d3]` has the tangent as its third column; curvature `kappa` is the
//! Darboux vector in that frame, `R' = R hat(kappa)`.
//!
//! Everything is in SI units and `f64`.

mod error;
mod fiber;
mod section;
pub mod so3;

pub use error::FiberError;
pub use fiber::{Fiber, Material, NodeProperties};
pub use section::Section;
