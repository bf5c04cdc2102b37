//! What sends light: lights of finite extent, distant ones, and the sky.

mod cone;
mod emitter;
mod lights;
mod map;
mod sky;
mod source;

pub use lights::{LightHit, LightSample, Lights};
pub use map::SkyMap;
pub use sky::Sky;
pub use source::Light;
