use super::frame::{Line, PreviewFrame};
use super::grid::SheetGrid;
use super::raster::Raster;
use super::view::View;
use crate::StudioError;
use crate::canvas::{Canvas, Color};
use nalgebra::Vector3;
use rapunzel_render::RenderError;

/// Width of the thinnest line, pixels: thinner fibres would break up.
const THINNEST: f64 = 1.3;
/// Width of the thinnest line where fibres are few and need not leave room for each other, pixels.
const THINNEST_OF_FEW: f64 = 2.2;
/// Number of fibres that are few.
pub(super) const FEW: usize = 10;

pub(super) const PAPER: Color = [0.965, 0.96, 0.95];
const FIBER: Color = [0.33, 0.19, 0.10];
const GLOSS: Color = [0.75, 0.58, 0.38];
const SURFACE: Color = [0.66, 0.71, 0.76];

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

/// The colour of a surface by its normal.
pub(super) fn surface_color(normal: &Vector3<f64>, view: &View) -> Color {
    // Without haze, which would show how far the surface is.
    let bright = 0.45 + 0.55 * normal.dot(&view.half_way).abs();
    SURFACE.map(|x| bright * x)
}

/// The colour of a fibre along a unit `tangent`: Kajiya and Kay's highlight of a light at the upper
/// left of the eye.
pub(super) fn fiber_color(tangent: &Vector3<f64>, view: &View) -> Color {
    let along = tangent.dot(&view.half_way);
    let gloss = (1.0 - along * along).max(0.0).powi(12);
    mix(FIBER, GLOSS, 0.8 * gloss)
}

/// A colour behind haze, which is 0 near and 1 far away.
pub(super) fn hazy(color: Color, haze: f64) -> Color {
    mix(color, PAPER, 0.5 * haze)
}

fn mix(a: Color, b: Color, t: f64) -> Color {
    [0, 1, 2].map(|k| a[k] + t * (b[k] - a[k]))
}

/// A position, rounded to a pixel.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within a sheet")]
pub(super) fn whole(x: f64) -> usize {
    x.round().clamp(0.0, 16384.0) as usize
}
