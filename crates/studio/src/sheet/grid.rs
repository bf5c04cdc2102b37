use super::view::View;
use crate::canvas::{Canvas, Color};
use nalgebra::{Point2, Point3};

/// Largest width and height of the sheet, pixels.
const SHEET: [f64; 2] = [1600.0, 1000.0];
/// Margin around each picture, pixels.
const MARGIN: f64 = 14.0;
/// Height of the caption with the time above each picture, pixels.
pub(super) const CAPTION: f64 = 22.0;

/// Positions of the pictures on the sheet.
pub(super) struct SheetGrid {
    columns: usize,
    rows: usize,
    /// Scale of the pictures, pixels per metre.
    pub(super) scale: f64,
    /// Size of a picture, pixels.
    pub(super) picture: [f64; 2],
}

impl SheetGrid {
    /// The grid that makes the pictures largest.
    pub(super) fn new(count: usize, view: &View) -> Self {
        let [width, height] = view.size;
        let best = |columns: usize| {
            let rows = count.div_ceil(columns);
            let across = (SHEET[0] - MARGIN) / columns as f64 - MARGIN;
            let down = (SHEET[1] - MARGIN - CAPTION) / rows as f64 - MARGIN - CAPTION;
            let scale = (across / width).min(down / height);
            Self { columns, rows, scale, picture: [scale * width, scale * height] }
        };
        (2..=count).map(best).fold(best(1), |a, b| if b.scale > a.scale { b } else { a })
    }

    /// A picture alone, of at most this width and height, pixels.
    pub(super) fn alone(view: &View, largest: [f64; 2]) -> Self {
        let [width, height] = view.size;
        let scale = (largest[0] / width).min(largest[1] / height);
        Self { columns: 1, rows: 1, scale, picture: [scale * width, scale * height] }
    }

    fn pitch(&self) -> [f64; 2] {
        [self.picture[0] + MARGIN, self.picture[1] + MARGIN + CAPTION]
    }

    /// Position of a point in the picture with the given corner, pixels.
    pub(super) fn place(&self, p: &Point3<f64>, view: &View, corner: [f64; 2]) -> Point2<f64> {
        let [x, y] = view.project(p);
        Point2::new(corner[0] + self.scale * x, corner[1] + self.scale * y)
    }

    /// Upper left corner of a picture, pixels.
    pub(super) fn corner(&self, cell: usize) -> [f64; 2] {
        let [across, down] = self.pitch();
        let (column, row) = (cell % self.columns, cell / self.columns);
        [MARGIN + column as f64 * across, CAPTION + MARGIN / 2.0 + row as f64 * down]
    }

    pub(super) fn size(&self) -> [f64; 2] {
        let [across, down] = self.pitch();
        [MARGIN + self.columns as f64 * across, MARGIN + CAPTION + self.rows as f64 * down]
    }

    /// Draws a bar of 1, 2 or 5 times a power of ten, about a third of a picture long.
    pub(super) fn scale_bar(&self, canvas: &mut Canvas, ink: Color) {
        let target = self.picture[0] / self.scale / 3.0;
        let decade = 10f64.powf(target.log10().floor());
        let length = [5.0, 2.0, 1.0].into_iter().find(|k| k * decade <= target).unwrap_or(1.0);
        let length = length * decade;
        let y = self.size()[1] - CAPTION / 2.0 - 4.0;
        let (from, to) = (Point2::new(MARGIN, y), Point2::new(MARGIN + self.scale * length, y));
        canvas.line(from, to, 3.0, ink);
        let (unit, name) = [(1.0, "m"), (1e-2, "cm"), (1e-3, "mm")]
            .into_iter()
            .find(|(unit, _)| length > 0.99 * unit)
            .unwrap_or((1e-6, "um"));
        canvas.text([to.x + 8.0, y - 7.0], &format!("{:.0} {name}", length / unit), ink);
    }
}

/// A position, rounded to a pixel.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within a sheet")]
pub(super) fn whole(x: f64) -> usize {
    x.round().clamp(0.0, 16384.0) as usize
}
