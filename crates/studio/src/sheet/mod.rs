//! A contact sheet: a run at a glance, as one PNG.

mod frame;
mod grid;
mod paint;
mod raster;
mod rose;
mod shade;
#[cfg(test)]
mod tests;
mod view;

use crate::StudioError;
use crate::canvas::{Canvas, Color};
pub use frame::{PreviewFrame, Support};
use grid::{CAPTION, SheetGrid};
use nalgebra::{Vector2, Vector3};
use paint::FEW;
use rapunzel_export::ExportError;
use rapunzel_export::surface::{self, Placed};
use raster::Raster;
use shade::PAPER;
use std::io::Write;
use view::View;

/// Largest number of frames on a sheet.
const CELLS: usize = 12;
/// Length by which a mark extends beyond the fibre that it is on, pixels.
const MARK: f64 = 3.0;
/// Length by which a mark extends beyond the fibre that it is on where fibres are few, pixels.
const MARK_OF_FEW: f64 = 6.0;

const INK: Color = [0.25, 0.25, 0.27];
const FRAME: Color = [0.84, 0.83, 0.81];

/// Writes a sheet of up to twelve of `frames`, evenly chosen, the first and the last among them.
///
/// All pictures share one orthographic view, from the side that shows the most of the box around
/// all frames and objects, and one scale, which the bar at the bottom gives for lengths across the
/// view: nothing is cut off. Near fibres are dark, far ones fade; a highlight shows their
/// direction, and marks show their supports. Behind and between the fibres are `objects`: one list
/// for each frame, or one for all frames, or none. `winds`, velocities of the air (world), m/s, one
/// for each frame or none, are shown by a wind rose each. Cost: of fibres a step for every pixel
/// that they are near, of objects a ray for every pixel of each frame, or of one if they are the
/// same in all.
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
    let view = view(frames, objects.iter().flatten(), !objects.is_empty())?;
    let count = frames.len().min(CELLS);
    let grid = SheetGrid::new(count, &view);
    let mut canvas = Canvas::new(grid.size(), PAPER);
    let backdrop = |objects: &[Placed]| Raster::new(objects, &view, &grid);
    // Most of the time objects are the same in all frames.
    let common = match objects {
        [] => Some(backdrop(&[])?),
        [one] => Some(backdrop(one)?),
        _ => None,
    };
    for cell in 0..count {
        let index = cell * (frames.len() - 1) / (count - 1).max(1);
        let (frame, corner) = (&frames[index], grid.corner(cell));
        let backdrop = common.clone().map_or_else(|| backdrop(&objects[index]), Ok)?;
        paint::paint(&mut canvas, frame, backdrop, &view, &grid, corner)?;
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
    grid.scale_bar(&mut canvas, INK);
    canvas.write(out)
}

/// Writes a picture of one frame and of objects, of at most `largest` pixels across and down, as it
/// would be seen on a sheet, without a scale. Cost: as of one frame of a sheet.
///
/// # Errors
/// As [`write()`].
pub fn write_small(
    out: &mut impl Write,
    frame: &PreviewFrame,
    objects: &[Placed],
    largest: [u16; 2],
) -> Result<(), StudioError> {
    objects.iter().try_for_each(|object| surface::check(&object.surface))?;
    let view = view(std::slice::from_ref(frame), objects.iter(), !objects.is_empty())?;
    let grid = SheetGrid::alone(&view, largest.map(f64::from));
    let mut canvas = Canvas::new(grid.picture, PAPER);
    let backdrop = Raster::new(objects, &view, &grid)?;
    paint::paint(&mut canvas, frame, backdrop, &view, &grid, [0.0; 2])?;
    mark(&mut canvas, frame, &view, &grid, [0.0; 2]);
    canvas.write(out)
}

/// The view of all frames and objects.
fn view<'a>(
    frames: &[PreviewFrame],
    objects: impl Iterator<Item = &'a Placed> + Clone,
    over_surfaces: bool,
) -> Result<View, StudioError> {
    let lines = frames.iter().flat_map(|frame| &frame.lines);
    let points = lines.clone().flat_map(frame::Line::points);
    let vertices = objects.flat_map(|object| &object.surface.vertices);
    let points = points.chain(vertices.copied());
    let radii = lines.flat_map(|line| &line.radii);
    let thickest = radii.fold(0.0, |a: f32, r| a.max(*r)).into();
    Ok(View::of(points, thickest, over_surfaces).ok_or(ExportError::Empty)?)
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
