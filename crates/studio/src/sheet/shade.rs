//! Colours of what a sheet shows.

use super::view::View;
use crate::canvas::Color;
use nalgebra::Vector3;

pub(super) const PAPER: Color = [0.965, 0.96, 0.95];
const FIBER: Color = [0.33, 0.19, 0.10];
const GLOSS: Color = [0.75, 0.58, 0.38];
const SURFACE: Color = [0.66, 0.71, 0.76];

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
