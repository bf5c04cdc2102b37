//! A contact sheet: a run at a glance, as one PNG.

mod canvas;
mod font;
mod rose;
mod view;

use super::{ExportError, Frame, Strand, surface};
use canvas::{Canvas, Color};
use nalgebra::{Point2, Point3, Vector3};
use rapunzel_collision::field::Soup;
use std::io::Write;
use view::View;

/// Most frames on a sheet.
const CELLS: usize = 12;
/// The sheet is no larger than this, pixels.
const SHEET: [f64; 2] = [1600.0, 1000.0];
/// Room around each picture and above it for its time, pixels.
const MARGIN: f64 = 14.0;
const CAPTION: f64 = 22.0;
/// Thinnest line, pixels: thinner fibres would break up.
const THINNEST: f64 = 1.3;
/// Thinnest line where fibres are few and need not leave room for each other, pixels.
const THINNEST_OF_FEW: f64 = 2.2;
const FEW: usize = 10;

const PAPER: Color = [0.965, 0.96, 0.95];
const INK: Color = [0.25, 0.25, 0.27];
const FRAME: Color = [0.84, 0.83, 0.81];
const FIBER: Color = [0.33, 0.19, 0.10];
const GLOSS: Color = [0.75, 0.58, 0.38];
const SURFACE: Color = [0.66, 0.71, 0.76];
/// How much a surface is seen beyond the box around all fibres, in largest sides of that.
const BEYOND: f64 = 0.25;

/// What a sheet shows of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Simulated time, s.
    pub time: f64,
    lines: Vec<Line>,
}

/// A fibre: its points (world) and the radii there, m, to a small part of a pixel.
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

impl Picture {
    /// The picture of a frame: a tenth of its bytes.
    ///
    /// # Errors
    /// Refuses unsound frames.
    pub fn new(frame: Frame) -> Result<Self, ExportError> {
        frame.validate()?;
        #[expect(clippy::cast_possible_truncation, reason = "it is more than is seen")]
        let line = |Strand { points, radii, .. }: Strand| Line {
            points: points.iter().map(|point| point.cast()).collect(),
            radii: radii.iter().map(|&radius| radius as f32).collect(),
        };
        Ok(Self { time: frame.time, lines: frame.strands.into_iter().map(line).collect() })
    }
}

/// Writes a sheet of up to twelve of `frames`, evenly chosen, the first and the last among them.
///
/// All pictures share one orthographic view, from the side that shows the most of the box around
/// all frames, and one scale, which the bar at the bottom gives for lengths across the view. Near
/// fibres are dark, far ones fade; a gloss shows how they lie. Behind and between the fibres are
/// `surfaces`: one for each frame, or one for all, or none; what of them is far from all fibres is
/// cut off. `winds`, velocities of the air (world), m/s, one for each frame or none, are shown by a
/// wind rose each. Cost: linear in the pixels that fibres and surfaces cover.
///
/// # Errors
/// Refuses no frames, frames without strands, unsound surfaces, surfaces that are neither one nor as many as the frames, and winds that are not as many or not finite; fails if `out` does.
pub fn write(
    out: &mut impl Write,
    frames: &[Picture],
    surfaces: &[Soup],
    winds: &[Vector3<f64>],
) -> Result<(), ExportError> {
    surfaces.iter().try_for_each(surface::check)?;
    if surfaces.len() > 1 && surfaces.len() != frames.len() {
        return Err(ExportError::Surface { what: "is missing for some of the frames" });
    }
    if !winds.is_empty() && winds.len() != frames.len() {
        return Err(ExportError::Wind { what: "is missing for some of the frames" });
    }
    let strongest = winds.iter().map(Vector3::norm).fold(0.0, f64::max);
    if !winds.iter().all(|wind| wind.norm().is_finite()) {
        return Err(ExportError::Wind { what: "is not finite" });
    }
    let lines = frames.iter().flat_map(|frame| &frame.lines);
    let points = lines.clone().flat_map(Line::points);
    let seen = seen(points.clone(), surfaces);
    let points = points.chain(seen.iter().copied());
    let radii = lines.flat_map(|line| &line.radii);
    let thickest = radii.fold(0.0, |a: f32, r| a.max(*r)).into();
    let view = View::of(points, thickest, !surfaces.is_empty()).ok_or(ExportError::Empty)?;
    let count = frames.len().min(CELLS);
    let grid = Grid::new(count, &view);
    let mut canvas = Canvas::new(grid.size(), PAPER);
    for cell in 0..count {
        let index = cell * (frames.len() - 1) / (count - 1).max(1);
        let (frame, surface) = (&frames[index], surfaces.get(index).or(surfaces.first()));
        let corner = grid.corner(cell);
        canvas.rectangle(corner, grid.picture, FRAME);
        // One picture alone is of no certain time.
        if count > 1 {
            let caption = [corner[0] + 2.0, corner[1] - CAPTION + 2.0];
            canvas.text(caption, &format!("{:.3} s", frame.time), INK);
        }
        surface.iter().for_each(|surface| draw_surface(&mut canvas, surface, &view, &grid, corner));
        draw(&mut canvas, frame, &view, &grid, corner);
        if let Some(wind) = winds.get(index).filter(|_| strongest > 0.0) {
            let corner = [corner[0] + grid.picture[0], corner[1]];
            rose::draw(&mut canvas, corner, &view, wind, strongest, INK);
        }
    }
    grid.scale_bar(&mut canvas);
    canvas.write(out)
}

/// The vertices of surfaces, moved into the box that is seen around some points.
fn seen(mut points: impl Iterator<Item = Point3<f64>>, surfaces: &[Soup]) -> Vec<Point3<f64>> {
    let Some(first) = points.next() else { return Vec::new() };
    let bounds = points.fold([first; 2], |[low, high], p| [low.inf(&p), high.sup(&p)]);
    let more = Vector3::repeat(BEYOND * (bounds[1] - bounds[0]).max());
    let [low, high] = [bounds[0] - more, bounds[1] + more];
    surfaces.iter().flat_map(|s| &s.vertices).map(|p| p.sup(&low).inf(&high)).collect()
}

/// Where the pictures are.
struct Grid {
    columns: usize,
    rows: usize,
    /// Pixels per metre.
    scale: f64,
    /// Size of a picture, pixels.
    picture: [f64; 2],
}

impl Grid {
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

    /// Where a point is in the picture with the given corner, pixels, and how far away, m.
    fn place(&self, p: &Point3<f64>, view: &View, corner: [f64; 2]) -> Point3<f64> {
        let [x, y] = view.project(p);
        Point3::new(corner[0] + self.scale * x, corner[1] + self.scale * y, view.distance(p))
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

    /// A bar of 1, 2 or 5 times a power of ten, about a third of a picture long.
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

/// Draws all fibres of `frame`, far segments first.
fn draw(canvas: &mut Canvas, frame: &Picture, view: &View, grid: &Grid, corner: [f64; 2]) {
    let segments = |line: &'_ Line| 0..line.points.len() - 1;
    let depth = |line: &Line, j: usize| view.depth(&line.points[j].cast());
    let mut segments: Vec<(f64, &Line, usize)> = frame
        .lines
        .iter()
        .flat_map(|line| segments(line).map(move |j| (depth(line, j), line, j)))
        .collect();
    segments.sort_by(|a, b| b.0.total_cmp(&a.0));
    let thinnest = if frame.lines.len() <= FEW { THINNEST_OF_FEW } else { THINNEST };
    for (depth, line, j) in segments {
        let [a, b] = [j, j + 1].map(|node| line.points[node].cast::<f64>());
        let radius = f64::from(line.radii[j]);
        let width = 2.0 * radius * grid.scale;
        let color = shade(&(b - a), view, depth);
        // What lies on a surface is in front of it, also where the axis is hidden by half.
        let nearer = Vector3::z() * (2.0 * radius + 1.0 / grid.scale);
        let [a, b] = [a, b].map(|p| grid.place(&p, view, corner) - nearer);
        canvas.stroke(a, b, width.max(thinnest), color);
    }
}

/// Draws a surface, bright where it faces between light and eye; without haze, which would show its
/// triangles.
fn draw_surface(canvas: &mut Canvas, surface: &Soup, view: &View, grid: &Grid, corner: [f64; 2]) {
    let window = [corner, [0, 1].map(|k| corner[k] + grid.picture[k])];
    for triangle in &surface.triangles {
        let corners = triangle.map(|v| surface.vertices[v as usize]);
        let [a, b, c] = corners;
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else { continue };
        let bright = 0.45 + 0.55 * normal.dot(&view.half_way).abs();
        let color = SURFACE.map(|x| bright * x);
        canvas.triangle(corners.map(|p| grid.place(&p, view, corner)), window, color);
    }
}

/// The colour of a fibre: Kajiya and Kay's highlight of a light at the upper left of the eye, and
/// haze with the depth (0 near, 1 far).
fn shade(tangent: &Vector3<f64>, view: &View, depth: f64) -> Color {
    let along = tangent.normalize().dot(&view.half_way);
    let gloss = if along.is_finite() { (1.0 - along * along).max(0.0).powi(12) } else { 0.0 };
    mix(mix(FIBER, GLOSS, 0.8 * gloss), PAPER, 0.5 * depth)
}

fn mix(a: Color, b: Color, t: f64) -> Color {
    [0, 1, 2].map(|k| a[k] + t * (b[k] - a[k]))
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    fn picture(frame: Frame) -> Picture {
        Picture::new(frame).expect("a sound frame")
    }

    fn decode(bytes: &[u8]) -> (png::OutputInfo, Vec<u8>) {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
        (reader.next_frame(&mut pixels).expect("pixels"), pixels)
    }

    #[test]
    fn a_sheet_is_a_png_with_dark_fibers_on_paper() {
        let frames: Vec<Picture> = (0..30).map(sample::frame).map(picture).collect();
        let mut bytes = Vec::new();
        write(&mut bytes, &frames, &[], &[]).expect("a sheet");
        let (info, pixels) = decode(&bytes);
        assert!(info.width <= 1650 && info.height <= 1050, "{info:?}");
        let dark = pixels.chunks(3).filter(|p| p[0] < 130).count();
        assert!(dark > 2000, "{dark} pixels of fibres");
        assert_eq!(pixels[..3], [246, 245, 242], "paper in the corner");
        let mut again = Vec::new();
        write(&mut again, &frames, &[], &[]).expect("a sheet");
        assert_eq!(bytes, again);
    }

    #[test]
    fn odd_shapes_have_a_sheet() {
        let mut line = sample::frame(0);
        for p in line.strands.iter_mut().flat_map(|s| &mut s.points) {
            (p.x, p.y) = (0.0, 0.0);
        }
        let mut dot = line.clone();
        dot.strands.iter_mut().flat_map(|s| &mut s.points).for_each(|p| p.z = 0.0);
        for frame in [line, dot] {
            let mut bytes = Vec::new();
            write(&mut bytes, &[picture(frame)], &[], &[]).expect("a sheet");
            assert!(decode(&bytes).0.width >= 20);
        }
        assert!(matches!(write(&mut Vec::new(), &[], &[], &[]), Err(ExportError::Empty)));
    }

    /// A wall hides what is behind it, and nothing of what is before it.
    #[test]
    fn surfaces_hide_what_is_behind_them() {
        let frame = picture(sample::frame(0));
        let dark = |offset: f64| {
            let wall = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]];
            let wall = Soup {
                vertices: wall.map(|[x, z]| Point3::new(x, offset - 0.05 * x, z)).to_vec(),
                triangles: vec![[0, 1, 2], [0, 2, 3]],
            };
            let mut bytes = Vec::new();
            write(&mut bytes, std::slice::from_ref(&frame), &[wall], &[]).expect("a sheet");
            decode(&bytes).1.chunks(3).filter(|p| p[0].saturating_sub(p[2]) > 20).count()
        };
        let (before, behind) = (dark(-0.5), dark(0.5));
        assert!(before == 0 && behind > 1000, "{before}, {behind}");
        let two = [Soup::default(), Soup::default()];
        let refused = write(&mut Vec::new(), &[frame.clone(), frame.clone(), frame], &two, &[]);
        assert!(matches!(refused, Err(ExportError::Surface { .. })));
    }

    /// The dark pixels of a rose come where wind blows, and its arrow lies the way it blows.
    #[test]
    fn a_rose_shows_the_wind() {
        let frame = picture(sample::frame(0));
        let sheet = |winds: &[Vector3<f64>]| {
            let mut bytes = Vec::new();
            write(&mut bytes, std::slice::from_ref(&frame), &[], winds).map(|()| decode(&bytes))
        };
        let calm = sheet(&[]).expect("a sheet");
        assert_eq!(sheet(&[Vector3::zeros()]).expect("a sheet").1, calm.1);
        let width = calm.0.width as usize;
        // Pixels that changed in a window below the upper right corner, left to right and down.
        let changed = |wind: Vector3<f64>| {
            let (_, pixels) = sheet(&[wind]).expect("a sheet");
            let pairs = pixels.chunks(3).zip(calm.1.chunks(3)).enumerate();
            let places = pairs.filter(|(_, (a, b))| a != b).map(|(i, _)| [i % width, i / width]);
            places.collect::<Vec<_>>()
        };
        let up = changed(Vector3::new(0.0, 0.0, 3.0));
        let down = changed(Vector3::new(0.0, 0.0, -3.0));
        assert!(up.len() > 100 && up.iter().all(|[x, _]| *x > width / 2), "{}", up.len());
        // Both arrows have their shafts in common; the heads lie at opposite ends.
        let only = |a: &[[usize; 2]], b: &[[usize; 2]]| {
            let rows: Vec<_> = a.iter().filter(|p| !b.contains(p)).map(|p| p[1] as f64).collect();
            rows.iter().sum::<f64>() / rows.len() as f64
        };
        assert!(only(&up, &down) + 5.0 < only(&down, &up));
        let refused = [vec![Vector3::x(); 2], vec![Vector3::repeat(f64::NAN)]];
        for winds in refused {
            assert!(matches!(sheet(&winds), Err(ExportError::Wind { .. })));
        }
    }
}
