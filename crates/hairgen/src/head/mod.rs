//! A head of our own: bald head, scalp, hairline and surfaces of hair, from measures.
//!
//! Frame: y up, the face looks along z, x to the person's left; the origin lies between the ears,
//! half-way between forehead and occiput.

mod hairline;
mod measures;
mod parametric;
mod shape;
mod volume;

pub use hairline::Hairline;
pub use measures::HeadMeasures;
pub use parametric::ParametricHead;
pub use volume::HairVolume;
