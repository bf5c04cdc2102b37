//! What all drawings have: a page of pixels, its colors, its letters.

use crate::PlotError;
use crate::ticks::round_below;
use plotters::coord::Shift;
use plotters::prelude::{
    Color, DrawingArea, IntoTextStyle, PathElement, RGBColor, SVGBackend, ShapeStyle, Text,
    TextStyle,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Width of every page, pixels as shown.
pub(crate) const WIDTH: f64 = 960.0;
/// Room for the title of a drawing and around it, pixels.
pub(crate) const TITLE: f64 = 40.0;
pub(crate) const MARGIN: f64 = 20.0;
/// Room for the caption of a picture, and within and between frames, pixels.
pub(crate) const CAPTION: f64 = 32.0;
pub(crate) const INSET: f64 = 12.0;
const GAP: f64 = 4.0;
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

/// The frame of a picture in a cell with this corner and size.
pub(crate) fn frame(page: &Page<'_>, corner: [f64; 2], cell: [f64; 2]) -> Result<(), PlotError> {
    // A rectangle of the library has a line of a fixed width.
    let ([left, top], [right, bottom]) = (corner, [0, 1].map(|i| corner[i] + cell[i] - GAP));
    let corners = [[left, top], [right, top], [right, bottom], [left, bottom], [left, top]];
    path(page, corners, line(PALE, 1.0))
}

/// A bar of a round length, at most `most` pixels, where a meter has `scale` pixels, and a text
/// beside it.
pub(crate) fn bar(
    page: &Page<'_>,
    y: f64,
    scale: f64,
    most: f64,
    text: &str,
) -> Result<(), PlotError> {
    let bar = round_below(most / scale);
    let end = MARGIN + scale * bar;
    path(page, [[MARGIN, y], [end, y]], line(INK, 1.0))?;
    for x in [MARGIN, end] {
        path(page, [[x, y - 4.0], [x, y + 4.0]], line(INK, 1.0))?;
    }
    let (length, unit) = if bar < 1e-3 { (1e6 * bar, "um") } else { (1e3 * bar, "mm") };
    write(page, [end + 10.0, y], 12.0, &format!("{length:.0} {unit}; {text}"))
}
