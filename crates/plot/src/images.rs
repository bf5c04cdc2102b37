use crate::page::{CAPTION, INSET, MARGIN, Page, TITLE, WIDTH, bar, frame, pixels, write};
use crate::{PlotError, quoted};
use std::fmt::Write;

/// Room for what is below, pixels.
const IMAGES_BELOW: f64 = 44.0;
/// Height of an image at most, pixels.
const HIGHEST: f64 = 360.0;

/// Images of one scale, side by side.
#[derive(Debug, Clone)]
pub struct Images {
    /// Their heading.
    pub title: String,
    /// What their colors mean, for the line below.
    pub legend: String,
    /// Side of their pixels, m.
    pub pixel: f64,
    /// How many stand side by side.
    pub columns: usize,
    /// What is drawn, row by row.
    pub images: Vec<Image>,
}

/// An image of colored pixels.
#[derive(Debug, Clone)]
pub struct Image {
    /// What stands above it.
    pub caption: String,
    /// Number of pixels in a row.
    pub width: usize,
    /// Red, green and blue of the pixels, row by row from the top.
    pub pixels: Vec<[u8; 3]>,
}

impl Image {
    fn height(&self) -> usize {
        self.pixels.len() / self.width.max(1)
    }

    /// The image as a PNG in the letters of base 64 (RFC 4648).
    fn encoded(&self) -> Result<String, PlotError> {
        let [width, height] = [self.width, self.height()].map(u32::try_from);
        let refused = |problem: String| PlotError::Image { caption: self.caption.clone(), problem };
        let (Ok(width), Ok(height)) = (width, height) else {
            return Err(refused("is too large".into()));
        };
        let mut png = Vec::new();
        let mut encoder = png::Encoder::new(&mut png, width, height);
        encoder.set_color(png::ColorType::Rgb);
        let written = encoder
            .write_header()
            .and_then(|mut writer| writer.write_image_data(self.pixels.as_flattened()));
        written.map_err(|error| refused(error.to_string()))?;
        Ok(base64(&png))
    }
}

/// Bytes as letters: six bits each, `=` where the last three are not whole.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let bits = (0..3).fold(0, |bits, k| bits << 8 | usize::from(*three.get(k).unwrap_or(&0)));
        for k in 0..4 {
            let letter = LETTERS[bits >> (18 - 6 * k) & 63];
            text.push(if k <= three.len() { char::from(letter) } else { '=' });
        }
    }
    text
}

impl Images {
    /// A row for each image: its size, and the area of what is not white.
    pub(crate) fn csv(&self) -> String {
        let mut rows = "image,width (m),height (m),area not white (m^2)\n".to_owned();
        for image in &self.images {
            let [width, height] = [image.width, image.height()].map(|n| n as f64 * self.pixel);
            let count = image.pixels.iter().filter(|&&pixel| pixel != [255; 3]).count();
            let (name, area) = (quoted(&image.caption), count as f64 * self.pixel * self.pixel);
            // Writing to a String cannot fail.
            let _ = writeln!(rows, "{name},{width:.6},{height:.6},{area:.8}");
        }
        rows
    }

    /// Pixels of the page for one of an image, and width and height of a cell.
    fn layout(&self) -> Result<(f64, [f64; 2]), PlotError> {
        if self.columns == 0 {
            return Err(PlotError::NoColumns);
        }
        let most = |of: fn(&Image) -> usize| self.images.iter().map(of).fold(1, usize::max) as f64;
        let [width, height] = [most(|image| image.width), most(Image::height)];
        let cell = (WIDTH - 2.0 * MARGIN) / self.columns as f64;
        let scale = ((cell - 2.0 * INSET) / width).min(HIGHEST / height);
        Ok((scale, [cell, scale * height + CAPTION + INSET]))
    }

    fn rows(&self) -> f64 {
        self.images.len().div_ceil(self.columns.max(1)) as f64
    }

    pub(crate) fn height(&self) -> Result<f64, PlotError> {
        Ok(TITLE + self.rows() * self.layout()?.1[1] + IMAGES_BELOW)
    }

    /// Draws all but the images; gives their elements, for a page on which this one begins `top`
    /// pixels below the upper edge.
    pub(crate) fn draw(&self, page: &Page<'_>, top: f64) -> Result<String, PlotError> {
        let (scale, cell) = self.layout()?;
        write(page, [MARGIN, 22.0], 16.0, &self.title)?;
        let mut elements = String::new();
        for (i, image) in self.images.iter().enumerate() {
            let (column, row) = (i % self.columns, i / self.columns);
            let corner = [MARGIN + cell[0] * column as f64, TITLE + cell[1] * row as f64];
            frame(page, corner, cell)?;
            write(page, [corner[0] + 8.0, corner[1] + 14.0], 12.0, &image.caption)?;
            let size = [image.width, image.height()].map(|count| scale * count as f64);
            let left = corner[0] + 0.5 * (cell[0] - size[0]);
            let [x, y] = [left, top + corner[1] + CAPTION].map(pixels);
            let [width, height] = size.map(pixels);
            let png = image.encoded()?;
            let _ = writeln!(
                elements,
                "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
                 href=\"data:image/png;base64,{png}\"/>"
            );
        }
        let (y, most) = (TITLE + cell[1] * self.rows() + 16.0, 0.25 * (cell[0] - 2.0 * INSET));
        bar(page, y, scale / self.pixel, most, &self.legend)?;
        Ok(elements)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples of RFC 4648.
    #[test]
    fn bytes_become_the_letters_of_the_standard() {
        let cases = ["", "", "f", "Zg==", "fo", "Zm8=", "foo", "Zm9v", "foobar", "Zm9vYmFy"];
        for pair in cases.chunks(2) {
            assert_eq!(base64(pair[0].as_bytes()), pair[1]);
        }
    }
}
