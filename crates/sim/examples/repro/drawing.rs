//! What figures are made of: charts of curves over time, and pictures of fibers side by side.

use crate::svg::{Anchor, Canvas, Stroke, WIDTH, round_below, ticks};
use nalgebra::{Point3, Vector3};
use std::fmt::Write;

/// Colors that the color-blind can tell apart (Okabe and Ito).
const COLORS: [&str; 7] =
    ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#222222", "#E69F00", "#56B4E9"];
const FIBER: &str = "#6b4423";
const LEFT: f64 = 80.0;
/// Room for the legend: the least, beside its names, and for a letter of them, pixels.
const RIGHT: f64 = 250.0;
const LEGEND: f64 = 50.0;
const LETTER: f64 = 6.6;
const LINE: f64 = 20.0;
const CHART: f64 = 300.0;
/// Room for the title of a drawing and for what is below it, pixels.
const ABOVE: f64 = 40.0;
const BELOW: f64 = 56.0;
const MARGIN: f64 = 20.0;

/// A part of a figure.
pub(crate) enum Drawing {
    Chart(Chart),
    Pictures(Pictures),
}

/// Curves over one abscissa; where both axes have one unit, they are shapes, and of one scale.
pub(crate) struct Chart {
    pub(crate) title: String,
    pub(crate) x: &'static str,
    pub(crate) y: &'static str,
    /// Smallest value of a logarithmic ordinate; `None` for a linear one.
    pub(crate) log_from: Option<f64>,
    pub(crate) curves: Vec<Curve>,
}

/// A curve and its name in the legend.
pub(crate) struct Curve {
    pub(crate) name: String,
    pub(crate) points: Vec<[f64; 2]>,
}

/// Fibers at several instants, all in one view and one scale.
pub(crate) struct Pictures {
    pub(crate) title: String,
    /// What the view is, for the line below.
    pub(crate) view: &'static str,
    /// Directions to the right and up, world frame.
    pub(crate) axes: [Vector3<f64>; 2],
    pub(crate) columns: usize,
    pub(crate) pictures: Vec<Picture>,
}

/// Fibers at one instant.
pub(crate) struct Picture {
    pub(crate) caption: String,
    /// Points of each fiber, m, world frame.
    pub(crate) fibers: Vec<Vec<Point3<f64>>>,
}

/// Draws a figure: its parts one below the other.
pub(crate) fn svg(drawings: &[Drawing]) -> String {
    let mut canvas = Canvas::default();
    let mut top = 0.0;
    for drawing in drawings {
        top += match drawing {
            Drawing::Chart(chart) => chart.draw(&mut canvas, top),
            Drawing::Pictures(pictures) => pictures.draw(&mut canvas, top),
        };
    }
    canvas.finish(top)
}

impl Drawing {
    /// The numbers, as they are drawn.
    pub(crate) fn csv(&self) -> String {
        let mut rows = String::new();
        // Writing to a String cannot fail.
        match self {
            Self::Chart(chart) => {
                let _ = writeln!(rows, "curve,{},{}", quoted(chart.x), quoted(chart.y));
                for curve in &chart.curves {
                    let name = quoted(&curve.name);
                    for [x, y] in &curve.points {
                        let _ = writeln!(rows, "{name},{x},{y}");
                    }
                }
            }
            Self::Pictures(pictures) => {
                rows += "picture,fiber,x (m),y (m),z (m)\n";
                for picture in &pictures.pictures {
                    let name = quoted(&picture.caption);
                    for (i, fiber) in picture.fibers.iter().enumerate() {
                        for p in fiber {
                            let _ = writeln!(rows, "{name},{i},{:.6},{:.6},{:.6}", p.x, p.y, p.z);
                        }
                    }
                }
            }
        }
        rows
    }
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// The smallest interval with all values; of some width even for equal ones.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [low, high] = values.fold([f64::MAX, f64::MIN], |[low, high], v| [low.min(v), high.max(v)]);
    if high > low { [low, high] } else { [low - 0.5, low + 0.5] }
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
    /// Draws below `top` and returns the height, pixels.
    fn draw(&self, canvas: &mut Canvas, top: f64) -> f64 {
        let points = || self.curves.iter().flat_map(|c| &c.points);
        let height = |y: f64| self.log_from.map_or(y, |least| y.max(least).log10());
        let mut xs = range(points().map(|p| p[0]));
        let [low, high] = range(points().map(|p| height(p[1])));
        let room = 0.04 * (high - low);
        let mut ys = [low - room, high + room];
        let longest = self.curves.iter().map(|c| c.name.chars().count()).max().unwrap_or(0);
        let right = RIGHT.max(LEGEND + LETTER * longest as f64);
        let tall = CHART.max(LINE * (self.curves.len() as f64 + 0.2));
        let (corner, size) = ([LEFT, top + ABOVE], [WIDTH - LEFT - right, tall]);
        if unit(self.x).is_some_and(|x| self.log_from.is_none() && unit(self.y) == Some(x)) {
            let scale = ((xs[1] - xs[0]) / size[0]).max((ys[1] - ys[0]) / size[1]);
            xs = widened(xs, scale * size[0]);
            ys = widened(ys, scale * size[1]);
        }
        let place = |x: f64, y: f64| {
            [
                corner[0] + size[0] * (x - xs[0]) / (xs[1] - xs[0]),
                corner[1] + size[1] * (ys[1] - y) / (ys[1] - ys[0]),
            ]
        };
        canvas.text([LEFT, top + 26.0], 16.0, Anchor::Start, &self.title);
        let (marks, decimals) = ticks(xs[0], xs[1], 8);
        for x in marks {
            let [px, py] = place(x, ys[0]);
            canvas.rule([px, corner[1]], [px, py], false);
            canvas.text([px, py + 17.0], 12.0, Anchor::Middle, &format!("{x:.decimals$}"));
        }
        let (marks, decimals) = ticks(ys[0], ys[1], 7);
        // A logarithmic axis is marked at whole powers of ten.
        let log = self.log_from.is_some();
        for y in marks.into_iter().filter(|y| !log || y.fract().abs() < 1e-9) {
            let [px, py] = place(xs[0], y);
            canvas.rule([px, py], [px + size[0], py], false);
            let label = if log { format!("1e{y:.0}") } else { format!("{y:.decimals$}") };
            canvas.text([px - 6.0, py + 4.0], 12.0, Anchor::End, &label);
        }
        canvas.frame(corner, size);
        for (i, curve) in self.curves.iter().enumerate() {
            let dash = if i < COLORS.len() { "" } else { "6 3" };
            let stroke = Stroke { color: COLORS[i % COLORS.len()], width: 1.3, dash };
            canvas.polyline(curve.points.iter().map(|p| place(p[0], height(p[1]))), &stroke);
            let (x, y) = (WIDTH - right + 14.0, corner[1] + 12.0 + LINE * i as f64);
            canvas.polyline([[x, y], [x + 22.0, y]], &Stroke { width: 2.5, ..stroke });
            canvas.text([x + 28.0, y + 4.0], 12.0, Anchor::Start, &curve.name);
        }
        let middle = corner[0] + 0.5 * size[0];
        canvas.text([middle, corner[1] + tall + 38.0], 13.0, Anchor::Middle, self.x);
        canvas.upward([22.0, corner[1] + 0.5 * tall], 13.0, self.y);
        ABOVE + tall + BELOW
    }
}

impl Pictures {
    fn draw(&self, canvas: &mut Canvas, top: f64) -> f64 {
        let flat = |p: &Point3<f64>| self.axes.map(|axis| axis.dot(&p.coords));
        let points = || self.pictures.iter().flat_map(|p| &p.fibers).flatten().map(flat);
        let (xs, ys) = (range(points().map(|p| p[0])), range(points().map(|p| p[1])));
        let cell = (WIDTH - 2.0 * MARGIN) / self.columns as f64;
        let inner = cell - 24.0;
        // No higher than a reader's screen.
        let tall = 280.0;
        let scale = (inner / (xs[1] - xs[0])).min(tall / (ys[1] - ys[0]));
        let caption = 24.0;
        let row = scale * (ys[1] - ys[0]) + caption + 20.0;
        canvas.text([MARGIN, top + 26.0], 16.0, Anchor::Start, &self.title);
        for (i, picture) in self.pictures.iter().enumerate() {
            let (column, line) = (i % self.columns, i / self.columns);
            let corner = [MARGIN + cell * column as f64, top + ABOVE + row * line as f64];
            let left = corner[0] + 0.5 * (cell - scale * (xs[1] - xs[0]));
            let place = |p: &Point3<f64>| {
                let [x, y] = flat(p);
                [left + scale * (x - xs[0]), corner[1] + caption + 8.0 + scale * (ys[1] - y)]
            };
            canvas.frame([corner[0] + 2.0, corner[1]], [cell - 4.0, row - 4.0]);
            canvas.text([corner[0] + 8.0, corner[1] + 16.0], 12.0, Anchor::Start, &picture.caption);
            let width = if picture.fibers.len() > 1 { 0.35 } else { 1.5 };
            let stroke = Stroke { color: FIBER, width, dash: "" };
            for fiber in &picture.fibers {
                canvas.polyline(fiber.iter().map(place), &stroke);
            }
            if let Some(root) = picture.fibers.first().and_then(|f| f.first()) {
                canvas.dot(place(root));
            }
        }
        let height = ABOVE + row * self.pictures.len().div_ceil(self.columns) as f64 + BELOW;
        let bar = round_below(0.5 * inner / scale);
        let y = top + height - BELOW + 24.0;
        canvas.rule([MARGIN, y], [MARGIN + scale * bar, y], true);
        for end in [MARGIN, MARGIN + scale * bar] {
            canvas.rule([end, y - 4.0], [end, y + 4.0], true);
        }
        let label = format!("{:.0} mm; {}; the dot is the root", 1e3 * bar, self.view);
        canvas.text([MARGIN + scale * bar + 10.0, y + 4.0], 12.0, Anchor::Start, &label);
        height
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A circle of lengths is drawn as one, and a long name in the legend ends in the drawing.
    #[test]
    fn shapes_keep_their_shape_and_legends_are_whole() {
        let circle = |i: u32| (std::f64::consts::TAU * f64::from(i) / 100.0).sin_cos();
        let points = (0..=100).map(circle).map(|(x, y)| [x, y]).collect();
        let name = "a long name of a curve that must not be cut at the edge of the drawing";
        let drawn = svg(&[Drawing::Chart(Chart {
            title: String::new(),
            x: "across (mm)",
            y: "height (mm)",
            log_from: None,
            curves: vec![Curve { name: name.into(), points }],
        })]);
        let all = drawn.lines().filter(|line| line.contains("polyline"));
        let list = all.map(|line| line.split('"').nth(1).expect("points"));
        let longest = list.max_by_key(|list| list.len()).expect("a curve");
        let number = |text: &str| text.parse::<f64>().expect("a number");
        let pairs = longest.split(' ').filter_map(|pair| pair.split_once(','));
        let [xs, ys]: [Vec<f64>; 2] = {
            let (xs, ys) = pairs.map(|(x, y)| (number(x), number(y))).unzip();
            [xs, ys]
        };
        let [x, y] = [range(xs.into_iter()), range(ys.into_iter())];
        assert!(((x[1] - x[0]) - (y[1] - y[0])).abs() < 0.3, "{x:?} {y:?}");
        let legend = drawn.lines().find(|line| line.contains(name)).expect("a legend");
        let at = number(legend.split('"').nth(1).expect("a place"));
        assert!(at + 6.0 * name.chars().count() as f64 <= WIDTH, "{at}");
    }

    #[test]
    fn parts_stand_below_each_other_and_all_numbers_are_kept() {
        let curve = |name: &str| Curve { name: name.into(), points: vec![[0.0, 1.0], [1.0, 1.0]] };
        let chart = Drawing::Chart(Chart {
            title: "flat".into(),
            x: "time (s)",
            y: "height (m)",
            log_from: None,
            curves: vec![curve("a"), curve("b")],
        });
        let pictures = Drawing::Pictures(Pictures {
            title: "line".into(),
            view: "x right",
            axes: [Vector3::x(), Vector3::z()],
            columns: 2,
            pictures: vec![Picture {
                caption: "t = 0".into(),
                fibers: vec![vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0)]],
            }],
        });
        assert_eq!(chart.csv().lines().count(), 5);
        assert_eq!(pictures.csv().lines().nth(2), Some("\"t = 0\",0,1.000000,0.000000,0.000000"));
        let drawn = svg(&[chart, pictures]);
        assert!(!drawn.contains("NaN") && !drawn.contains("inf"), "{drawn}");
        let at = |text: &str| drawn.find(text).expect("is drawn");
        assert!(at(">flat<") < at(">line<") && drawn.contains(">time (s)<"));
    }
}
