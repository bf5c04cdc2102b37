use super::Tone;
use crate::check::check;
use crate::{Film, RenderError};
use png::{ColorType, Encoder, SrgbRenderingIntent};
use std::io::{self, Write};

/// Writes the means of a picture as a PNG of 8 bits a color, in the color space of sRGB, `exposure`
/// stops brighter than it is.
///
/// If it is `transparent`, the picture has the coverage of its pixels as alpha, and radiance is
/// divided by it; what is behind the surfaces must then not be in the samples.
///
/// # Errors
/// [`RenderError::Parameter`] if `exposure` is not finite; [`RenderError::Io`] if `out` fails.
pub fn write_png(
    out: impl Write,
    film: &Film,
    tone: Tone,
    exposure: f64,
    transparent: bool,
) -> Result<(), RenderError> {
    check("the exposure (stops)", exposure, "finite", exposure.is_finite())?;
    let [width, height] = film.size();
    let mut bytes = Vec::new();
    for pixel in film.pixels() {
        // What no sample met has no radiance to divide.
        let alpha = if transparent { pixel.coverage() } else { 1.0 };
        let radiance = pixel.radiance() / if alpha > 0.0 { alpha } else { 1.0 };
        bytes.extend(tone.encoded(&radiance, exposure).map(byte));
        if transparent {
            bytes.push(byte(alpha));
        }
    }
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(if transparent { ColorType::Rgba } else { ColorType::Rgb });
    encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
    let written = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(&bytes)?;
        writer.finish()
    });
    Ok(written.map_err(io::Error::other)?)
}

/// A value in `[0, 1]` in 8 bits.
#[expect(clippy::cast_possible_truncation, reason = "the value is in [0, 255]")]
fn byte(value: f64) -> u8 {
    (255.0 * value).round() as u8
}
