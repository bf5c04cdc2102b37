#![doc = include_str!("../README.md")]

mod axis;
mod chart;
mod error;
mod images;
mod page;
mod pictures;
mod ticks;

pub use chart::{Chart, Curve};
pub use error::PlotError;
pub use images::{Image, Images};
pub use pictures::{Picture, Pictures};

use page::{WIDTH, pixels};
use plotters::prelude::{IntoDrawingArea, SVGBackend, WHITE};

/// A part of a figure.
#[derive(Debug, Clone)]
pub enum Drawing {
    /// Curves over one abscissa.
    Chart(Chart),
    /// Fibers at several instants.
    Pictures(Pictures),
    /// Images of pixels.
    Images(Images),
}

/// Draws a figure, its parts one below the other, as the text of an SVG file 960 pixels wide.
///
/// # Errors
/// If pictures have no columns, an image is none, or the library refuses an element.
pub fn svg(drawings: &[Drawing]) -> Result<String, PlotError> {
    let heights = drawings.iter().map(Drawing::height).collect::<Result<Vec<_>, _>>()?;
    let size = [WIDTH, heights.iter().sum::<f64>().ceil()];
    let [wide, high] = size.map(|length| pixels(length).unsigned_abs());
    let mut text = String::new();
    let root = SVGBackend::with_string(&mut text, (wide, high)).into_drawing_area();
    root.fill(&WHITE)?;
    let (mut rest, mut top) = (root.clone(), 0.0);
    // The library draws no images of pixels: they come last.
    let mut images_drawn = String::new();
    for (drawing, height) in drawings.iter().zip(heights) {
        let (here, below) = rest.split_vertically(pixels(height));
        match drawing {
            Drawing::Chart(chart) => chart.draw(&here)?,
            Drawing::Pictures(pictures) => pictures.draw(&here)?,
            Drawing::Images(images) => images_drawn += &images.draw(&here, top)?,
        }
        (rest, top) = (below, top + height);
    }
    root.present()?;
    drop((root, rest));
    // The library counts in whole pixels, so what it draws is larger than what is shown.
    let drawn = format!("width=\"{wide}\" height=\"{high}\"");
    let shown = format!("width=\"{}\" height=\"{}\"", size[0], size[1]);
    Ok(text.replacen(&drawn, &shown, 1).replace("</svg>", &format!("{images_drawn}</svg>")))
}

impl Drawing {
    fn height(&self) -> Result<f64, PlotError> {
        match self {
            Self::Chart(chart) => Ok(chart.height()),
            Self::Pictures(pictures) => pictures.height(),
            Self::Images(images) => images.height(),
        }
    }

    /// The numbers as they are drawn: a table with a row for each point of each curve or fiber, and
    /// a head with the labels of the axes; of images their sizes and areas.
    #[must_use]
    pub fn csv(&self) -> String {
        match self {
            Self::Chart(chart) => chart.csv(),
            Self::Pictures(pictures) => pictures.csv(),
            Self::Images(images) => images.csv(),
        }
    }
}

/// A cell of a table.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// The smallest interval with all finite values; of some width even for equal ones or none.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let finite = values.filter(|v| v.is_finite());
    let [low, high] = finite.fold([f64::MAX, f64::MIN], |[low, high], v| [low.min(v), high.max(v)]);
    let least = 1e-9 * low.abs().max(high.abs());
    match high - low {
        _ if low > high => [-0.5, 0.5],
        width if width > least => [low, high],
        _ => [low - least.max(0.5), high + least.max(0.5)],
    }
}

#[cfg(test)]
mod tests;
