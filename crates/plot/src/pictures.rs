use crate::page::{
    CAPTION, INK, INSET, MARGIN, Page, TITLE, WIDTH, bar, frame, line, path, pixels, place, write,
};
use crate::{PlotError, quoted, range};
use nalgebra::{Point3, Vector3};
use plotters::prelude::{Circle, Color, RGBColor};
use std::fmt::Write;

const FIBER: RGBColor = RGBColor(0x6b, 0x44, 0x23);
/// Room for what is below, pixels.
const PICTURE_BELOW: f64 = 56.0;
/// Height of the fibers in a picture at most, so that a row fits on a screen, pixels.
const TALLEST: f64 = 280.0;

/// Fibers at several instants, all in one view and one scale.
#[derive(Debug, Clone)]
pub struct Pictures {
    /// Their heading.
    pub title: String,
    /// What the view is, for the line below.
    pub view: &'static str,
    /// Directions to the right and up, world frame.
    pub axes: [Vector3<f64>; 2],
    /// How many pictures stand side by side.
    pub columns: usize,
    /// What is drawn, row by row.
    pub pictures: Vec<Picture>,
}

/// Fibers at one instant.
#[derive(Debug, Clone)]
pub struct Picture {
    /// What stands above it.
    pub caption: String,
    /// Points of each fiber from its root on, m, world frame.
    pub fibers: Vec<Vec<Point3<f64>>>,
}

/// How pictures stand on a page, pixels.
struct PageLayout {
    /// Lowest and highest coordinate to the right and up, m.
    bounds: [[f64; 2]; 2],
    /// Pixels in a meter.
    scale: f64,
    /// Width and height of a cell.
    cell: [f64; 2],
}

impl Pictures {
    pub(crate) fn csv(&self) -> String {
        let mut rows = "picture,fiber,x (m),y (m),z (m)\n".to_owned();
        for picture in &self.pictures {
            let name = quoted(&picture.caption);
            for (i, fiber) in picture.fibers.iter().enumerate() {
                for p in fiber {
                    // Writing to a String cannot fail.
                    let _ = writeln!(rows, "{name},{i},{:.6},{:.6},{:.6}", p.x, p.y, p.z);
                }
            }
        }
        rows
    }

    fn seen(&self, p: &Point3<f64>) -> [f64; 2] {
        self.axes.map(|axis| axis.dot(&p.coords))
    }

    fn layout(&self) -> Result<PageLayout, PlotError> {
        if self.columns == 0 {
            return Err(PlotError::NoColumns);
        }
        let points = || self.pictures.iter().flat_map(|p| &p.fibers).flatten();
        let bounds = [0, 1].map(|i| range(points().map(|p| self.seen(p)[i])));
        let [width, height] = bounds.map(|[low, high]| high - low);
        let cell = (WIDTH - 2.0 * MARGIN) / self.columns as f64;
        let scale = ((cell - 2.0 * INSET) / width).min(TALLEST / height);
        Ok(PageLayout { bounds, scale, cell: [cell, scale * height + CAPTION + INSET] })
    }

    pub(crate) fn height(&self) -> Result<f64, PlotError> {
        let rows = self.pictures.len().div_ceil(self.columns.max(1)) as f64;
        Ok(TITLE + rows * self.layout()?.cell[1] + PICTURE_BELOW)
    }

    pub(crate) fn draw(&self, page: &Page<'_>) -> Result<(), PlotError> {
        let PageLayout { bounds: [xs, ys], scale, cell } = self.layout()?;
        write(page, [MARGIN, 22.0], 16.0, &self.title)?;
        for (i, picture) in self.pictures.iter().enumerate() {
            let (column, row) = (i % self.columns, i / self.columns);
            let corner = [MARGIN + cell[0] * column as f64, TITLE + cell[1] * row as f64];
            let left = corner[0] + 0.5 * (cell[0] - scale * (xs[1] - xs[0]));
            let top = corner[1] + CAPTION;
            let on_page = |p: &Point3<f64>| {
                let [x, y] = self.seen(p);
                [left + scale * (x - xs[0]), top + scale * (ys[1] - y)]
            };
            frame(page, corner, cell)?;
            write(page, [corner[0] + 8.0, corner[1] + 14.0], 12.0, &picture.caption)?;
            let style = line(FIBER, if picture.fibers.len() > 1 { 0.4 } else { 1.5 });
            let finite = |p: &&Point3<f64>| p.iter().all(|x| x.is_finite());
            for fiber in &picture.fibers {
                path(page, fiber.iter().filter(finite).map(on_page), style)?;
            }
            let root = picture.fibers.first().and_then(|f| f.first()).filter(finite);
            if let Some(root) = root {
                page.draw(&Circle::new(place(on_page(root)), pixels(2.5), INK.filled()))?;
            }
        }
        let rows = self.pictures.len().div_ceil(self.columns) as f64;
        let (y, most) = (TITLE + cell[1] * rows + 20.0, 0.5 * (cell[0] - 2.0 * INSET));
        bar(page, y, scale, most, &format!("{}; the dot is the root", self.view))
    }
}
