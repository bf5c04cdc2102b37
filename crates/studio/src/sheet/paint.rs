use super::frame::{Line, PreviewFrame};
use super::grid::{SheetGrid, whole};
use super::raster::Raster;
use super::view::View;
use crate::StudioError;
use crate::canvas::Canvas;
use rapunzel_render::RenderError;

/// Width of the thinnest line, pixels: thinner fibres would break up.
const THINNEST: f64 = 1.3;
/// Width of the thinnest line where fibres are few and need not leave room for each other, pixels.
const THINNEST_OF_FEW: f64 = 2.2;
/// Number of fibres that are few.
pub(super) const FEW: usize = 10;

/// Draws the fibres of a frame before a `backdrop` of surfaces into a picture, each pixel of which
/// shows the mean of its four corners.
pub(super) fn paint(
    canvas: &mut Canvas,
    frame: &PreviewFrame,
    backdrop: Raster,
    view: &View,
    grid: &SheetGrid,
    corner: [f64; 2],
) -> Result<(), StudioError> {
    let is_finite = |line: &Line| {
        line.points().all(|p| p.iter().all(|x| x.is_finite()))
            && line.radii.iter().all(|radius| radius.is_finite())
    };
    if let Some(fiber) = frame.lines.iter().position(|line| !is_finite(line)) {
        let what = "is too far away or too thick to be drawn";
        return Err(RenderError::Curve { fiber, what }.into());
    }
    let thinnest = if frame.lines.len() <= FEW { THINNEST_OF_FEW } else { THINNEST };
    let mut raster = backdrop;
    raster.draw(&frame.lines, view, 0.5 * thinnest / grid.scale);
    let [left, top] = corner.map(whole);
    raster.pixels(|[x, y], color| canvas.set(left + x, top + y, color));
    Ok(())
}
