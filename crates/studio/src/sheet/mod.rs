//! A contact sheet: a run at a glance, as one PNG.

mod paint;
mod rose;
#[cfg(test)]
mod tests;
mod view;

use crate::StudioError;
use crate::canvas::{Canvas, Color};
use nalgebra::{Point2, Point3, Vector2, Vector3};
use rapunzel_export::surface::{self, Placed};
use rapunzel_export::{ExportError, Frame, Strand};
use std::io::Write;
use view::View;

/// Largest number of frames on a sheet.
const CELLS: usize = 12;
/// Largest width and height of the sheet, pixels.
const SHEET: [f64; 2] = [1600.0, 1000.0];
/// Margin around each picture, pixels.
const MARGIN: f64 = 14.0;
/// Height of the caption with the time above each picture, pixels.
const CAPTION: f64 = 22.0;
/// Width of the thinnest line, pixels: thinner fibres would break up.
const THINNEST: f64 = 1.3;
/// Width of the thinnest line where fibres are few and need not leave room for each other, pixels.
const THINNEST_OF_FEW: f64 = 2.2;
const FEW: usize = 10;
/// Length by which a mark extends beyond the fibre that it is on, pixels.
const MARK: f64 = 3.0;
/// Length by which a mark extends beyond the fibre that it is on where fibres are few, pixels.
const MARK_OF_FEW: f64 = 6.0;

const PAPER: Color = [0.965, 0.96, 0.95];
const INK: Color = [0.25, 0.25, 0.27];
const FRAME: Color = [0.84, 0.83, 0.81];

/// The data of a frame that a sheet shows.
#[derive(Debug, Clone, PartialEq)]
pub struct PreviewFrame {
    /// Simulated time, s.
    pub time: f64,
    lines: Vec<Line>,
    supports: Vec<Support>,
}

/// A support of a point of a strand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Support {
    /// Index of the strand in the frame.
    pub strand: usize,
    /// Index of the point in the strand.
    pub point: usize,
    /// Whether the strand cannot rotate there: a clamp is drawn as a bar across it, a joint as a
    /// ring.
    pub clamped: bool,
}

/// A fibre in single precision: its points (world) and the radii there, m, to a small fraction of a
/// pixel.
#[derive(Debug, Clone, PartialEq)]
struct Line {
    points: Vec<Point3<f32>>,
    radii: Vec<f32>,
}

impl Line {
    fn points(&self) -> impl Iterator<Item = Point3<f64>> + Clone {
        self.points.iter().map(|point| point.cast())
    }
}

impl PreviewFrame {
    /// Keeps what a sheet shows of a frame and of the supports of its strands: a tenth of its
    /// bytes.
    ///
    /// # Errors
    /// Refuses invalid frames, and supports of points that do not exist.
    pub fn new(frame: Frame, supports: Vec<Support>) -> Result<Self, ExportError> {
        frame.validate()?;
        let there = |support: &Support| {
            frame.strands.get(support.strand).is_some_and(|s| support.point < s.points.len())
        };
        if !supports.iter().all(there) {
            let what = "a support is of a point that is not there";
            return Err(ExportError::Series { index: frame.index, what });
        }
        #[expect(clippy::cast_possible_truncation, reason = "it is more than is seen")]
        let line = |Strand { points, radii, .. }: Strand| Line {
            points: points.iter().map(|point| point.cast()).collect(),
            radii: radii.iter().map(|&radius| radius as f32).collect(),
        };
        let lines = frame.strands.into_iter().map(line).collect();
        Ok(Self { time: frame.time, lines, supports })
    }
}

/// Writes a sheet of up to twelve of `frames`, evenly chosen, the first and the last among them.
///
/// All pictures share one orthographic view, from the side that shows the most of the box around
/// all frames and objects, and one scale, which the bar at the bottom gives for lengths across the
/// view: nothing is cut off. Near fibres are dark, far ones fade; a highlight shows their
/// direction, and marks show their supports. Behind and between the fibres are `objects`: one list
/// for each frame, or one for all frames, or none. `winds`, velocities of the air (world), m/s, one
/// for each frame or none, are shown by a wind rose each. Cost: a ray for every pixel, and the
/// trees of what is shown.
///
/// # Errors
/// Refuses an empty list of frames, frames without strands, invalid surfaces, objects that are
/// neither for one frame nor for all, and winds that are not as many as frames or not finite; fails
/// if `out` does.
pub fn write(
    out: &mut impl Write,
    frames: &[PreviewFrame],
    objects: &[Vec<Placed>],
    winds: &[Vector3<f64>],
) -> Result<(), StudioError> {
    objects.iter().flatten().try_for_each(|object| surface::check(&object.surface))?;
    if objects.len() > 1 && objects.len() != frames.len() {
        let what = "is missing for some of the frames";
        return Err(ExportError::Surface { what }.into());
    }
    if !winds.is_empty() && winds.len() != frames.len() {
        return Err(StudioError::Wind { what: "is missing for some of the frames" });
    }
    let strongest = winds.iter().map(Vector3::norm).fold(0.0, f64::max);
    if !winds.iter().all(|wind| wind.norm().is_finite()) {
        return Err(StudioError::Wind { what: "is not finite" });
    }
    let lines = frames.iter().flat_map(|frame| &frame.lines);
    let points = lines.clone().flat_map(Line::points);
    let vertices = objects.iter().flatten().flat_map(|object| &object.surface.vertices);
    let points = points.chain(vertices.copied());
    let radii = lines.flat_map(|line| &line.radii);
    let thickest = radii.fold(0.0, |a: f32, r| a.max(*r)).into();
    let view = View::of(points, thickest, !objects.is_empty()).ok_or(ExportError::Empty)?;
    let count = frames.len().min(CELLS);
    let grid = SheetGrid::new(count, &view);
    let mut canvas = Canvas::new(grid.size(), PAPER);
    for cell in 0..count {
        let index = cell * (frames.len() - 1) / (count - 1).max(1);
        let (frame, objects) = (&frames[index], objects.get(index).or(objects.first()));
        let corner = grid.corner(cell);
        let objects = objects.map_or(&[][..], Vec::as_slice);
        paint::paint(&mut canvas, frame, objects, &view, &grid, corner)?;
        canvas.rectangle(corner, grid.picture, FRAME);
        // One picture alone is of no certain time.
        if count > 1 {
            let caption = [corner[0] + 2.0, corner[1] - CAPTION + 2.0];
            canvas.text(caption, &format!("{:.3} s", frame.time), INK);
        }
        mark(&mut canvas, frame, &view, &grid, corner);
        if let Some(wind) = winds.get(index).filter(|_| strongest > 0.0) {
            let corner = [corner[0] + grid.picture[0], corner[1]];
            rose::draw(&mut canvas, corner, &view, wind, strongest, INK);
        }
    }
    grid.scale_bar(&mut canvas);
    canvas.write(out)
}

/// Positions of the pictures on the sheet.
struct SheetGrid {
    columns: usize,
    rows: usize,
    /// Scale of the pictures, pixels per metre.
    scale: f64,
    /// Size of a picture, pixels.
    picture: [f64; 2],
}

impl SheetGrid {
    /// The grid that makes the pictures largest.
    fn new(count: usize, view: &View) -> Self {
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

    fn pitch(&self) -> [f64; 2] {
        [self.picture[0] + MARGIN, self.picture[1] + MARGIN + CAPTION]
    }

    /// Position of a point in the picture with the given corner, pixels.
    fn place(&self, p: &Point3<f64>, view: &View, corner: [f64; 2]) -> Point2<f64> {
        let [x, y] = view.project(p);
        Point2::new(corner[0] + self.scale * x, corner[1] + self.scale * y)
    }

    /// Upper left corner of a picture, pixels.
    fn corner(&self, cell: usize) -> [f64; 2] {
        let [across, down] = self.pitch();
        let (column, row) = (cell % self.columns, cell / self.columns);
        [MARGIN + column as f64 * across, CAPTION + MARGIN / 2.0 + row as f64 * down]
    }

    fn size(&self) -> [f64; 2] {
        let [across, down] = self.pitch();
        [MARGIN + self.columns as f64 * across, MARGIN + CAPTION + self.rows as f64 * down]
    }

    /// Draws a bar of 1, 2 or 5 times a power of ten, about a third of a picture long.
    fn scale_bar(&self, canvas: &mut Canvas) {
        let target = self.picture[0] / self.scale / 3.0;
        let decade = 10f64.powf(target.log10().floor());
        let length = [5.0, 2.0, 1.0].into_iter().find(|k| k * decade <= target).unwrap_or(1.0);
        let length = length * decade;
        let y = self.size()[1] - CAPTION / 2.0 - 4.0;
        let (from, to) = (Point2::new(MARGIN, y), Point2::new(MARGIN + self.scale * length, y));
        canvas.line(from, to, 3.0, INK);
        let (unit, name) = [(1.0, "m"), (1e-2, "cm"), (1e-3, "mm")]
            .into_iter()
            .find(|(unit, _)| length > 0.99 * unit)
            .unwrap_or((1e-6, "um"));
        canvas.text([to.x + 8.0, y - 7.0], &format!("{:.0} {name}", length / unit), INK);
    }
}

/// Draws marks at the supports of the fibres of `frame`, in front of everything.
fn mark(
    canvas: &mut Canvas,
    frame: &PreviewFrame,
    view: &View,
    grid: &SheetGrid,
    corner: [f64; 2],
) {
    let beyond = if frame.lines.len() <= FEW { MARK_OF_FEW } else { MARK };
    for Support { strand, point, clamped } in &frame.supports {
        let points = &frame.lines[*strand].points;
        let place = |i: usize| grid.place(&points[i].cast(), view, corner);
        let neighbour = if *point == 0 { 1 } else { point - 1 };
        let (center, along) = (place(*point), place(neighbour) - place(*point));
        // Beyond both sides of a thick one.
        let half = beyond + f64::from(frame.lines[*strand].radii[*point]) * grid.scale;
        // Of a fibre that is seen from its end any direction is across.
        let across = Vector2::new(-along.y, along.x).try_normalize(1e-9).unwrap_or(Vector2::x());
        let arm = half * across;
        if *clamped {
            canvas.line(center - arm, center + arm, 0.5 * beyond, INK);
        } else {
            canvas.ring(center, half, INK);
        }
    }
}
