//! Files of pictures: PNG to look at, EXR to compute with, and maps of the sky.

mod exr_map;
mod exr_picture;
mod png_picture;
mod tone;

pub use exr_map::read_exr_map;
pub use exr_picture::write_exr;
pub use png_picture::write_png;
pub use tone::Tone;
