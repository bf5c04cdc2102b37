use crate::size::pixel_count;
use crate::{RenderError, SkyMap};
use exr::prelude::{MetaData, ReadChannels as _, ReadLayers as _, Vec2, read};
use nalgebra::Vector3;
use std::io;

/// Reads a map of the sky, in linear light, from an EXR: the first layer that has channels `R`, `G`
/// and `B`; `up` and `rotation` are those of [`SkyMap::new`].
///
/// # Errors
/// [`RenderError::SkyMap`] if it is no EXR, cut short or damaged, has no such channels, or its
/// pixels are no light; [`RenderError::PictureSize`] if it is too large;
/// [`RenderError::Parameter`] if `up` or `rotation` is none; [`RenderError::Io`] if `input` fails.
pub fn read_exr_map(
    mut input: impl io::Read + io::Seek,
    up: &Vector3<f64>,
    rotation: f64,
) -> Result<SkyMap, RenderError> {
    let start = input.stream_position()?;
    // Before memory is taken for what a file says that it holds.
    let meta = MetaData::read_from_buffered(&mut input, false).map_err(bad)?;
    for header in &meta.headers {
        sides(header.layer_size)?;
    }
    input.seek(io::SeekFrom::Start(start))?;
    let reader = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0.0; 3]; size.area()]),
            |(width, pixels): &mut (usize, Vec<[f32; 3]>), at, (r, g, b): (f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes();
    let layer = reader.from_buffered(input).map_err(bad)?.layer_data;
    let [width, height] = sides(layer.size)?;
    SkyMap::new(width, height, layer.channel_data.pixels.1, up, rotation)
}

/// Width and height of a picture that can be held.
fn sides(size: Vec2<usize>) -> Result<[u32; 2], RenderError> {
    let sides = [size.width(), size.height()].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    pixel_count(sides).map(|_| sides)
}

fn bad(error: exr::error::Error) -> RenderError {
    match error {
        exr::error::Error::Io(error) => RenderError::Io(error),
        other => RenderError::SkyMap { problem: format!("as an EXR it is {other}") },
    }
}
