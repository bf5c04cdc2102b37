use crate::{Film, FilmPixel, RenderError};
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    WritableImage as _,
};
use std::io;

/// Writes the means of a picture as an EXR, in linear light.
///
/// Channels, in single precision: `R`, `G`, `B` and `A` (radiance, W/(m^2 sr), and coverage);
/// `albedo.R`, `.G` and `.B`; `normal.X`, `.Y` and `.Z` (world); `depth.Z` (m, infinite where no
/// sample met a surface); and `fiber.id`, whole numbers of 32 bits, [`FilmPixel::NO_FIBER`] where
/// there is none. They are compressed without loss. Numbers beyond single precision are cut off.
///
/// # Errors
/// [`RenderError::Io`] if `out` fails.
pub fn write_exr(out: impl io::Write + io::Seek, film: &Film) -> Result<(), RenderError> {
    let channel = |name: &str, of: &dyn Fn(&FilmPixel) -> f64| {
        let samples = film.pixels().iter().map(|pixel| single(of(pixel))).collect();
        AnyChannel::new(name, FlatSamples::F32(samples))
    };
    let fiber = film.pixels().iter().map(FilmPixel::fiber).collect();
    let channels = vec![
        channel("R", &|p| p.radiance().x),
        channel("G", &|p| p.radiance().y),
        channel("B", &|p| p.radiance().z),
        channel("A", &FilmPixel::coverage),
        channel("albedo.R", &|p| p.albedo().x),
        channel("albedo.G", &|p| p.albedo().y),
        channel("albedo.B", &|p| p.albedo().z),
        channel("normal.X", &|p| p.normal().x),
        channel("normal.Y", &|p| p.normal().y),
        channel("normal.Z", &|p| p.normal().z),
        channel("depth.Z", &|p| p.depth().unwrap_or(f64::INFINITY)),
        AnyChannel::new("fiber.id", FlatSamples::U32(fiber)),
    ];
    let [width, height] = film.size().map(|n| n as usize);
    let encoding = Encoding { compression: Compression::ZIP16, ..Encoding::UNCOMPRESSED };
    let attributes = LayerAttributes::default();
    let layer =
        Layer::new((width, height), attributes, encoding, AnyChannels::sort(channels.into()));
    let written = Image::from_layer(layer).write().to_buffered(out);
    Ok(written.map_err(io::Error::other)?)
}

/// The nearest number in single precision, infinite only if the value is.
#[expect(clippy::cast_possible_truncation, reason = "the file is in single precision")]
fn single(value: f64) -> f32 {
    if value.is_finite() { (value as f32).clamp(f32::MIN, f32::MAX) } else { value as f32 }
}
