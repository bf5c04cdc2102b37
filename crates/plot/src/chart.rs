use crate::axis::PlotAxis;
use crate::page::{GREY, INK, PALE, Page, TITLE, WIDTH, letters, line, path, pixels, write};
use crate::{PlotError, quoted, range};
use plotters::prelude::{
    ChartBuilder, Circle, Color, DashedLineSeries, LineSeries, RGBColor, TRANSPARENT,
};
use std::fmt::Write;

/// Colors that the color-blind can tell apart (Okabe and Ito).
const COLORS: [RGBColor; 7] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    INK,
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
];
/// Room below and to the left of the axes for labels, and around all, pixels.
const CHART_BELOW: f64 = 60.0;
const LEFT: f64 = 80.0;
const CHART_GAP: f64 = 12.0;
/// Room for the legend: the least, beside its names, and for a letter of them, pixels.
const RIGHT: f64 = 250.0;
const LEGEND: f64 = 50.0;
const LETTER: f64 = 6.6;
/// Height of a line of the legend, and of the axes, pixels.
const LINE: f64 = 20.0;
const AXES: f64 = 300.0;
/// A curve of fewer points shows them.
const FEW: usize = 25;

/// Curves over one abscissa; where both axes have one unit, they are shapes, and of one scale.
#[derive(Debug, Clone)]
pub struct Chart {
    /// Its heading.
    pub title: String,
    /// Label of the abscissa, with its unit in brackets if it has one.
    pub x: &'static str,
    /// Label of the ordinate, with its unit in brackets if it has one.
    pub y: &'static str,
    /// Smallest value of a logarithmic ordinate, in its unit: smaller ones are drawn there; `None`
    /// for a linear one.
    pub log_from: Option<f64>,
    /// What is drawn, first to last.
    pub curves: Vec<Curve>,
}

/// A curve and its name in the legend.
#[derive(Debug, Clone)]
pub struct Curve {
    /// What the legend says.
    pub name: String,
    /// Abscissa and ordinate of its points, in the units of the axes.
    pub points: Vec<[f64; 2]>,
}

/// The unit in the brackets of a label, if it has one.
fn unit(label: &str) -> Option<&str> {
    let (_, unit) = label.strip_suffix(')')?.rsplit_once('(')?;
    Some(unit)
}

/// The interval of the same middle and another width.
fn widened([low, high]: [f64; 2], width: f64) -> [f64; 2] {
    let middle = 0.5 * (low + high);
    [middle - 0.5 * width, middle + 0.5 * width]
}

impl Chart {
    pub(crate) fn csv(&self) -> String {
        let mut rows = format!("curve,{},{}\n", quoted(self.x), quoted(self.y));
        for curve in &self.curves {
            let name = quoted(&curve.name);
            for [x, y] in &curve.points {
                // Writing to a String cannot fail.
                let _ = writeln!(rows, "{name},{x},{y}");
            }
        }
        rows
    }

    pub(crate) fn height(&self) -> f64 {
        TITLE + CHART_GAP + self.axes_height() + CHART_BELOW
    }

    fn axes_height(&self) -> f64 {
        AXES.max(LINE * (self.curves.len() as f64 + 0.2))
    }

    fn legend_width(&self) -> f64 {
        let longest = self.curves.iter().map(|c| c.name.chars().count()).max().unwrap_or(0);
        RIGHT.max(LEGEND + LETTER * longest as f64).min(0.6 * WIDTH)
    }

    /// Where an ordinate is on its axis.
    fn on_axis(&self, y: f64) -> f64 {
        self.log_from.map_or(y, |least| y.max(least).log10())
    }

    /// Ends of both axes, that of a logarithmic one as powers of ten.
    fn ranges(&self) -> [[f64; 2]; 2] {
        let points = || self.curves.iter().flat_map(|c| &c.points);
        let xs = range(points().map(|p| p[0]));
        let [low, high] = range(points().map(|p| self.on_axis(p[1])));
        if self.log_from.is_some() && high.floor() - low.ceil() < 1.0 {
            return [xs, [low.floor(), high.ceil()]];
        }
        let room = 0.04 * (high - low);
        let ys = [low - room, high + room];
        if self.log_from.is_some() || unit(self.x).is_none() || unit(self.x) != unit(self.y) {
            return [xs, ys];
        }
        let size = [WIDTH - LEFT - self.legend_width(), self.axes_height()];
        let scale = ((xs[1] - xs[0]) / size[0]).max((ys[1] - ys[0]) / size[1]);
        [widened(xs, scale * size[0]), widened(ys, scale * size[1])]
    }

    pub(crate) fn draw(&self, page: &Page<'_>) -> Result<(), PlotError> {
        let (title, rest) = page.split_vertically(pixels(TITLE));
        write(&title, [LEFT, 22.0], 16.0, &self.title)?;
        let (left, legend) = rest.split_horizontally(pixels(WIDTH - self.legend_width()));
        self.draw_axes(&left)?;
        for (i, curve) in self.curves.iter().enumerate() {
            let y = CHART_GAP + 12.0 + LINE * i as f64;
            let color = COLORS[i % COLORS.len()];
            let ends = if i < COLORS.len() {
                vec![[14.0, 36.0]]
            } else {
                vec![[14.0, 22.0], [28.0, 36.0]]
            };
            for [from, to] in ends {
                path(&legend, [[from, y], [to, y]], line(color, 2.5))?;
            }
            write(&legend, [42.0, y], 12.0, &curve.name)?;
        }
        Ok(())
    }

    fn draw_axes(&self, page: &Page<'_>) -> Result<(), PlotError> {
        let [xs, ys] = self.ranges();
        let mut chart = ChartBuilder::on(page)
            .margin_top(pixels(CHART_GAP))
            .margin_left(pixels(CHART_GAP))
            .margin_bottom(pixels(CHART_GAP))
            .x_label_area_size(pixels(CHART_BELOW - CHART_GAP))
            .y_label_area_size(pixels(LEFT - CHART_GAP))
            .build_cartesian_2d(
                PlotAxis::new(xs, 8.0, false),
                PlotAxis::new(ys, 8.0, self.log_from.is_some()),
            )?;
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .label_style(letters(12.0))
            .axis_desc_style(letters(13.0))
            .bold_line_style(line(PALE, 1.0))
            .light_line_style(TRANSPARENT)
            .axis_style(line(GREY, 1.0))
            .set_all_tick_mark_size(pixels(4.0))
            .draw()?;
        for (i, curve) in self.curves.iter().enumerate() {
            let style = line(COLORS[i % COLORS.len()], 1.3);
            let finite = |p: &[f64; 2]| p[0].is_finite() && self.on_axis(p[1]).is_finite();
            let at = |p: &[f64; 2]| (p[0], self.on_axis(p[1]));
            // A point that has no place is a gap.
            for part in curve.points.split(|p| !finite(p)).filter(|part| !part.is_empty()) {
                let points = part.iter().map(at);
                if i < COLORS.len() {
                    chart.draw_series(LineSeries::new(points, style))?;
                } else {
                    let [dash, gap] = [6.0, 3.0].map(pixels);
                    chart.draw_series(DashedLineSeries::new(points, dash, gap, style))?;
                }
            }
            if curve.points.len() < FEW {
                let points = curve.points.iter().filter(|p| finite(p)).map(at);
                let dot = |p| Circle::new(p, pixels(2.2), style.color.filled());
                chart.draw_series(points.map(dot))?;
            }
        }
        Ok(())
    }
}
