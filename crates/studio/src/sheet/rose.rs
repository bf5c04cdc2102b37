use super::view::View;
use crate::canvas::{Canvas, Color};
use nalgebra::{Point2, Rotation2, Vector3};
use std::f64::consts::PI;

/// Radius of the ring of the wind rose, pixels.
const RADIUS: f64 = 15.0;
/// Margin to the right of and below the caption with the speed, pixels.
const ROOM: f64 = 4.0;

/// Draws a wind rose into the upper right corner of a picture: a ring, in it an arrow along the
/// wind as the view shows it, whose length is the wind's part across the view over the strongest
/// speed, and below it the speed.
pub(super) fn draw(
    canvas: &mut Canvas,
    corner: [f64; 2],
    view: &View,
    wind: &Vector3<f64>,
    strongest: f64,
    ink: Color,
) {
    let center = Point2::new(corner[0] - RADIUS - ROOM, corner[1] + RADIUS + ROOM);
    canvas.ring(center, RADIUS, ink);
    let across = view.across(wind) * (RADIUS / strongest);
    let tip = center + across;
    canvas.line(center - across, tip, 1.5, ink);
    for angle in [0.85 * PI, -0.85 * PI] {
        canvas.line(tip, tip + Rotation2::new(angle) * across * 0.7, 1.5, ink);
    }
    let speed = format!("{:.1} m/s", wind.norm());
    let left = corner[0] - Canvas::text_width(&speed) - ROOM;
    canvas.text([left, corner[1] + 2.0 * RADIUS + 2.0 * ROOM], &speed, ink);
}
