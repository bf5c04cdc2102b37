//! What all drawings have: a page of pixels, its colors, its letters.

use crate::PlotError;
use plotters::coord::Shift;
use plotters::prelude::{
    Color, DrawingArea, IntoTextStyle, PathElement, RGBColor, SVGBackend, ShapeStyle, Text,
    TextStyle,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Width of every page, pixels as shown.
pub(crate) const WIDTH: f64 = 960.0;
/// The library's whole pixels in one that is shown.
const FINE: f64 = 10.0;
pub(crate) const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
pub(crate) const GREY: RGBColor = RGBColor(0x88, 0x88, 0x88);
pub(crate) const PALE: RGBColor = RGBColor(0xd8, 0xd8, 0xd8);

pub(crate) type Page<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Shown pixels as the library counts them.
#[expect(clippy::cast_possible_truncation, reason = "what is too large is cut off at the border")]
pub(crate) fn pixels(length: f64) -> i32 {
    (length * FINE).round() as i32
}

pub(crate) fn place([x, y]: [f64; 2]) -> (i32, i32) {
    (pixels(x), pixels(y))
}

/// A line of a width, pixels.
pub(crate) fn line(color: RGBColor, width: f64) -> ShapeStyle {
    color.stroke_width(pixels(width).unsigned_abs())
}

/// Letters of a height, pixels.
pub(crate) fn letters(size: f64) -> TextStyle<'static> {
    // The library makes a font smaller by this factor.
    ("sans-serif", size * FINE * 1.24).with_color(INK).into_text_style(&(1, 1))
}

/// Writes a text, to the right of a place and about its height.
pub(crate) fn write(page: &Page<'_>, at: [f64; 2], size: f64, text: &str) -> Result<(), PlotError> {
    let style = letters(size).pos(Pos::new(HPos::Left, VPos::Center));
    Ok(page.draw(&Text::new(text, place(at), style))?)
}

pub(crate) fn path(
    page: &Page<'_>,
    points: impl IntoIterator<Item = [f64; 2]>,
    style: ShapeStyle,
) -> Result<(), PlotError> {
    let points: Vec<_> = points.into_iter().map(place).collect();
    Ok(page.draw(&PathElement::new(points, style))?)
}

pub(crate) fn frame(page: &Page<'_>, corner: [f64; 2], size: [f64; 2]) -> Result<(), PlotError> {
    // A rectangle of the library has a line of a fixed width.
    let ([left, top], [right, bottom]) = (corner, [corner[0] + size[0], corner[1] + size[1]]);
    let corners = [[left, top], [right, top], [right, bottom], [left, bottom], [left, top]];
    path(page, corners, line(PALE, 1.0))
}
