//! What a picture is gathered in.

mod pixel;
mod plane;
mod state;

pub use pixel::{FilmPixel, FilmSample, FirstSurface};
pub use plane::Film;
pub use state::FilmKey;
