#![doc = include_str!("../README.md")]

mod camera;
mod check;
mod color;
mod curves;
mod error;
mod film;
mod image;
mod light;
mod mesh;
mod path;
mod random;
mod ray;
mod scene;
mod size;
mod tracer;
mod tree;
mod vertex;

pub use camera::{Camera, Projection};
pub use curves::{CurveForm, CurveHit, Curves, FiberCurve, TubePoint};
pub use error::RenderError;
pub use film::{Film, FilmKey, FilmPixel, FilmSample, FirstSurface};
pub use image::{Tone, read_exr_map, write_exr, write_png};
pub use light::{Light, LightHit, LightSample, Lights, Sky, SkyMap};
pub use mesh::{FacePoint, MeshHit, TriangleMesh};
pub use path::LightSearch;
pub use random::PathRandom;
pub use ray::Ray;
pub use scene::{FiberLook, Hairs, RenderScene};
pub use tracer::PathTracer;
