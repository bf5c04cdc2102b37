use super::font;
use crate::StudioError;
use nalgebra::{Point2, Rotation2, Vector2, Vector3};
use rapunzel_render::Film;
use std::f64::consts::TAU;
use std::io::Write;

/// Red, green and blue in `[0, 1]`, in display (not linear) values.
pub(super) type Color = [f64; 3];

/// A stored color: finer than the byte of the file, at half the memory of a [`Color`].
type Pixel = [f32; 3];

/// Width and height of a pixel of the font, pixels.
const LETTER_SCALE: usize = 2;
/// Number of sides of the polygon that approximates a ring.
const SIDES: usize = 24;

/// An image to draw on; positions are in pixels from the upper left corner.
pub(super) struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<Pixel>,
}

impl Canvas {
    pub(super) fn new(size: [f64; 2], paper: Color) -> Self {
        let [width, height] = size.map(|x| clamped(x.ceil(), 1 << 14).max(1));
        Self { width, height, pixels: vec![pixel(paper); width * height] }
    }

    /// Lays colors over a pixel.
    pub(super) fn set(&mut self, x: usize, y: usize, color: Color) {
        if x < self.width && y < self.height {
            self.pixels[y * self.width + x] = pixel(color);
        }
    }

    /// Lays a film over, its left edge at `left`, its pixels encoded for display by `encode`.
    pub(super) fn picture(
        &mut self,
        left: f64,
        film: &Film,
        encode: impl Fn(&Vector3<f64>) -> Color,
    ) {
        let (left, columns) = (clamped(left, self.width), film.size()[0] as usize);
        for (index, pixel) in film.pixels().iter().enumerate() {
            self.set(left + index % columns, index / columns, encode(&pixel.radiance()));
        }
    }

    /// Draws a line of the given width with round ends. Antialiased: the coverage of a pixel goes
    /// from zero half a pixel outside of the line to one half a pixel inside.
    pub(super) fn line(&mut self, a: Point2<f64>, b: Point2<f64>, width: f64, color: Color) {
        let reach = 0.5 * width + 1.0;
        let along = b - a;
        let squared = along.norm_squared();
        let columns =
            clamped(a.x.min(b.x) - reach, self.width)..clamped(a.x.max(b.x) + reach, self.width);
        let rows =
            clamped(a.y.min(b.y) - reach, self.height)..clamped(a.y.max(b.y) + reach, self.height);
        for y in rows {
            for x in columns.clone() {
                let p = Point2::new(x as f64 + 0.5, y as f64 + 0.5) - a;
                let t = if squared > 0.0 { (p.dot(&along) / squared).clamp(0.0, 1.0) } else { 0.0 };
                let cover = 0.5 * width + 0.5 - (p - t * along).norm();
                self.blend(x, y, color, cover.clamp(0.0, 1.0));
            }
        }
    }

    /// Draws a ring.
    pub(super) fn ring(&mut self, center: Point2<f64>, radius: f64, color: Color) {
        let rim = |k: usize| {
            let turn = Rotation2::new(TAU * k as f64 / SIDES as f64);
            center + radius * turn.transform_vector(&Vector2::x())
        };
        (0..SIDES).for_each(|k| self.line(rim(k), rim(k + 1), 1.0, color));
    }

    /// Fills a rectangle.
    pub(super) fn fill(&mut self, corner: [f64; 2], size: [f64; 2], color: Color) {
        let range = |k: usize, limit: usize| {
            clamped(corner[k].round(), limit)..clamped((corner[k] + size[k]).round(), limit)
        };
        for y in range(1, self.height) {
            for x in range(0, self.width) {
                self.pixels[y * self.width + x] = pixel(color);
            }
        }
    }

    /// Draws the outline of a rectangle.
    pub(super) fn rectangle(&mut self, corner: [f64; 2], size: [f64; 2], color: Color) {
        let at = |x: f64, y: f64| {
            Point2::new(corner[0] + x * size[0], corner[1] + y * size[1]).map(|x| x.round() + 0.5)
        };
        let corners = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
        for i in 0..4 {
            self.line(corners[i], corners[(i + 1) % 4], 1.0, color);
        }
    }

    /// Width of a text, pixels.
    pub(super) fn text_width(text: &str) -> f64 {
        (text.chars().count() * (font::SIZE[0] + 1) * LETTER_SCALE) as f64
    }

    /// Draws text with its upper left corner at `corner`.
    pub(super) fn text(&mut self, corner: [f64; 2], text: &str, color: Color) {
        let [left, top] = corner.map(|x| clamped(x.round(), 1 << 14));
        for (i, letter) in text.chars().enumerate() {
            let left = left + i * (font::SIZE[0] + 1) * LETTER_SCALE;
            for (row, bits) in font::rows(letter).into_iter().enumerate() {
                for column in
                    (0..font::SIZE[0]).filter(|c| bits >> (font::SIZE[0] - 1 - c) & 1 == 1)
                {
                    let corner = [left + column * LETTER_SCALE, top + row * LETTER_SCALE];
                    for k in 0..LETTER_SCALE * LETTER_SCALE {
                        let (x, y) = (corner[0] + k % LETTER_SCALE, corner[1] + k / LETTER_SCALE);
                        if x < self.width && y < self.height {
                            self.blend(x, y, color, 1.0);
                        }
                    }
                }
            }
        }
    }

    pub(super) fn write(&self, out: &mut impl Write) -> Result<(), StudioError> {
        let bytes: Vec<u8> = self.pixels.iter().flatten().map(|x| byte(*x)).collect();
        // The size is at most 2^14 on a side.
        let [width, height] =
            [self.width, self.height].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
        let mut encoder = png::Encoder::new(out, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::Fast);
        encoder
            .write_header()
            .and_then(|mut writer| {
                writer.write_image_data(&bytes)?;
                writer.finish()
            })
            .map_err(|error| std::io::Error::other(error).into())
    }

    fn blend(&mut self, x: usize, y: usize, color: Color, opacity: f64) {
        let pixel = &mut self.pixels[y * self.width + x];
        for (kept, color) in pixel.iter_mut().zip(color) {
            *kept += single(opacity * (color - f64::from(*kept)));
        }
    }
}

fn pixel(color: Color) -> Pixel {
    color.map(single)
}

#[expect(clippy::cast_possible_truncation, reason = "a shade needs no more digits")]
fn single(x: f64) -> f32 {
    x as f32
}

#[expect(clippy::cast_possible_truncation, reason = "clamped to a byte before")]
fn byte(x: f32) -> u8 {
    (255.0 * x).round().clamp(0.0, 255.0) as u8
}

/// `x` rounded to an index in `0..=limit`.
#[expect(clippy::cast_possible_truncation, reason = "clamped to an index before")]
fn clamped(x: f64, limit: usize) -> usize {
    x.clamp(0.0, limit as f64) as usize
}
