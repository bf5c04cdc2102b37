#![doc = include_str!("../README.md")]

mod camera;
mod check;
mod color;
mod error;
mod film;
mod image;
mod light;
mod random;
mod ray;
mod size;

pub use camera::{Camera, Projection};
pub use error::RenderError;
pub use film::{Film, FilmKey, FilmPixel, FilmSample, FirstSurface};
pub use image::{Tone, read_exr_map, write_exr, write_png};
pub use light::{Light, LightHit, LightSample, Lights, Sky, SkyMap};
pub use random::PathRandom;
pub use ray::Ray;
