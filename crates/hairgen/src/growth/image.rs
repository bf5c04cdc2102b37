//! Grey images over the disc.

use crate::HairgenError;
use nalgebra::Point2;
use png::{BitDepth, ColorType, Decoder};
use std::io::Cursor;

/// Pixels along a side at most.
const LARGEST_SIDE: u32 = 4096;

/// A square image of grey values from 0 to 255 on the square from -1 to 1 that holds the unit
/// disc: the first row is at the top, at positive `y`. Between the middles of the pixels values
/// are bilinear, beyond the outermost ones constant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GreyImage {
    side: usize,
    values: Vec<u8>,
}

impl GreyImage {
    /// An image from its values by rows, the first at the top.
    ///
    /// # Errors
    /// [`HairgenError::ImageSize`] if it is not square or has less than 2 pixels along a side.
    pub fn new(width: usize, values: Vec<u8>) -> Result<Self, HairgenError> {
        let height = values.len().checked_div(width).unwrap_or(0);
        if width < 2 || width * width != values.len() {
            return Err(HairgenError::ImageSize { width, height });
        }
        Ok(Self { side: width, values })
    }

    /// An image from the bytes of a PNG file of 8 bits: grey, or colors whose red, green and blue
    /// are equal everywhere.
    ///
    /// # Errors
    /// [`HairgenError::ImageFile`] for what is no PNG, [`HairgenError::ImageKind`] for 16 or fewer
    /// than 8 bits, palettes, transparency and colors, [`HairgenError::ImageSize`] if it is not
    /// square, has less than 2 or more than 4096 pixels along a side.
    pub fn from_png(bytes: &[u8]) -> Result<Self, HairgenError> {
        let broken =
            |error: png::DecodingError| HairgenError::ImageFile { problem: error.to_string() };
        let mut reader = Decoder::new(Cursor::new(bytes)).read_info().map_err(broken)?;
        let info = reader.info();
        let (width, height) = (info.width, info.height);
        let found = match (info.color_type, info.bit_depth) {
            (ColorType::Grayscale | ColorType::Rgb, BitDepth::Eight) => None,
            (ColorType::Indexed, _) => Some("a palette".to_owned()),
            (ColorType::GrayscaleAlpha | ColorType::Rgba, _) => Some("transparency".to_owned()),
            (_, depth) => Some(format!("{} bits a channel", depth as u8)),
        };
        if let Some(found) = found {
            return Err(HairgenError::ImageKind { found });
        }
        if width != height || width > LARGEST_SIDE {
            let [width, height] = [width, height].map(|n| n as usize);
            return Err(HairgenError::ImageSize { width, height });
        }
        let channels = if info.color_type == ColorType::Rgb { 3 } else { 1 };
        let mut values = vec![0; channels * width as usize * height as usize];
        reader.next_frame(&mut values).map_err(broken)?;
        if channels == 3 {
            if values.chunks_exact(3).any(|rgb| rgb[0] != rgb[1] || rgb[1] != rgb[2]) {
                return Err(HairgenError::ImageKind { found: "colors".to_owned() });
            }
            values = values.into_iter().step_by(3).collect();
        }
        Self::new(width as usize, values)
    }

    /// Pixels along a side.
    #[must_use]
    pub fn side(&self) -> usize {
        self.side
    }

    /// The value at a place of the disc: 0 for black, 1 for white.
    #[must_use]
    pub fn value(&self, place: &Point2<f64>) -> f64 {
        self.around(place).iter().map(|(weight, value)| weight * value).sum()
    }

    /// The four pixels around a place of the disc: weights, of sum 1, and values from 0 to 1.
    pub(super) fn around(&self, place: &Point2<f64>) -> [(f64, f64); 4] {
        let (column, x) = self.pixel(0.5 * (1.0 + place.x));
        let (row, y) = self.pixel(0.5 * (1.0 - place.y));
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(right, down)| {
            let weight = |beyond: usize, t: f64| if beyond == 1 { t } else { 1.0 - t };
            let value = self.values[(row + down) * self.side + column + right];
            (weight(right, x) * weight(down, y), f64::from(value) / 255.0)
        })
    }

    /// The pixel whose middle is at or before a place from 0 to 1 along a side, the last but one at
    /// most, and the fraction to the next.
    fn pixel(&self, place: f64) -> (usize, f64) {
        // What is not a number becomes the first.
        let last = (self.side - 1) as f64;
        let at = (self.side as f64 * place - 0.5).max(0.0).min(last);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let pixel = (at as usize).min(self.side - 2);
        (pixel, at - pixel as f64)
    }
}
