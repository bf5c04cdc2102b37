//! Tests of pictures.

mod film;
mod image;
mod lights;
