use crate::canvas::{Canvas, Color};
use crate::coloring::viridis;
use crate::{ColorRange, Coloring, StudioError};
use rapunzel_render::{Film, Tone};
use std::io::Write;

/// Height of the bar of colors, of that of the picture.
const HEIGHT: f64 = 0.3;
/// Width of the bar, and room around all, pixels.
const BAR: f64 = 14.0;
const SPACE: f64 = 12.0;
/// Height of a line of text, pixels.
const LINE: f64 = 18.0;
/// Bottom and top of the field behind the legend, and ink on it.
const FIELD: Color = [0.97, 0.97, 0.96];
const LETTERS: Color = [0.2, 0.2, 0.22];

/// Writes the means of a picture as a PNG, `exposure` stops brighter than it is, with a legend of
/// the colors of fibres beside it, on the left.
///
/// # Errors
/// [`StudioError::Io`] if `out` fails.
pub fn write_with_legend(
    out: &mut impl Write,
    film: &Film,
    (tone, exposure): (Tone, f64),
    (coloring, range): (Coloring, &ColorRange),
) -> Result<(), StudioError> {
    let [width, height] = film.size();
    let bar = (HEIGHT * f64::from(height)).max(4.0 * LINE);
    let labels = [1.0, 0.5, 0.0].map(|t| number(range.low + t * (range.high - range.low)));
    let of_labels = labels.iter().map(|label| Canvas::text_width(label)).fold(0.0, f64::max);
    let title = coloring.title();
    let of_title = title.map_or(0.0, Canvas::text_width);
    let wide = of_title.max(BAR + 0.5 * SPACE + of_labels) + 2.0 * SPACE;
    let left = if title.is_some() { wide.round() } else { 0.0 };
    let mut canvas = Canvas::new([left + f64::from(width), f64::from(height)], FIELD);
    canvas.picture(left, film, |radiance| tone.encoded(radiance, exposure));
    let Some(title) = title else { return canvas.write(out) };
    canvas.text([SPACE, SPACE], title, LETTERS);
    let top = SPACE + 1.5 * LINE;
    let rows = bar.round();
    let mut row = 0.0;
    while row < rows {
        let linear = viridis(1.0 - row / (rows - 1.0));
        // As the file shows it: what is seen of fibres has light and shade besides.
        let color = Tone::Srgb.encoded(&linear, 0.0);
        canvas.fill([SPACE, top + row], [BAR, 1.0], color);
        row += 1.0;
    }
    for (label, place) in labels.iter().zip([0.0, 0.5, 1.0]) {
        let at = [SPACE + BAR + 0.5 * SPACE, top + place * (bar - 14.0)];
        canvas.text(at, label, LETTERS);
    }
    canvas.write(out)
}

/// A number with three digits.
fn number(x: f64) -> String {
    if x == 0.0 || (1e-2..1e4).contains(&x.abs()) {
        let digits = if x.abs() >= 100.0 {
            0
        } else if x.abs() >= 10.0 {
            1
        } else {
            2
        };
        format!("{x:.digits$}")
    } else {
        format!("{x:.1e}")
    }
}
