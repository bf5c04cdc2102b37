//! Tests of what can be drawn with, and of pictures, through the public interface.

mod curves;
mod film;
mod image;
mod lights;
mod paths;
mod wavy;
