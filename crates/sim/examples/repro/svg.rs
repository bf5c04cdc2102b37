//! SVG drawings, with no more in them than charts of lines and pictures of fibers.

use std::fmt::Write;

/// Width of every drawing, pixels.
pub(crate) const WIDTH: f64 = 960.0;
const INK: &str = "#222222";
const PALE: &str = "#d8d8d8";

/// The elements of a drawing; x runs to the right and y down, pixels.
#[derive(Default)]
pub(crate) struct Canvas(String);

/// Which end of a text is at its position.
#[derive(Clone, Copy)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

impl Canvas {
    pub(crate) fn text(&mut self, at: [f64; 2], size: f64, anchor: Anchor, text: &str) {
        self.element(at, size, anchor, text, "");
    }

    /// A text that reads upward.
    pub(crate) fn upward(&mut self, at: [f64; 2], size: f64, text: &str) {
        let turn = format!(" transform=\"rotate(-90 {:.1} {:.1})\"", at[0], at[1]);
        self.element(at, size, Anchor::Middle, text, &turn);
    }

    fn element(&mut self, at: [f64; 2], size: f64, anchor: Anchor, text: &str, more: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        let [x, y] = at;
        self.push(&format!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" text-anchor=\"{anchor}\"\
             {more}>{text}</text>"
        ));
    }

    pub(crate) fn frame(&mut self, corner: [f64; 2], size: [f64; 2]) {
        let ([x, y], [w, h]) = (corner, size);
        self.push(&format!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" fill=\"none\" \
             stroke=\"{PALE}\"/>"
        ));
    }

    pub(crate) fn rule(&mut self, from: [f64; 2], to: [f64; 2], dark: bool) {
        let stroke = Stroke { color: if dark { INK } else { PALE }, width: 1.0, dash: "" };
        self.polyline([from, to], &stroke);
    }

    pub(crate) fn dot(&mut self, at: [f64; 2]) {
        let [x, y] = at;
        self.push(&format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.5\" fill=\"{INK}\"/>"));
    }

    pub(crate) fn polyline(
        &mut self,
        points: impl IntoIterator<Item = [f64; 2]>,
        stroke: &Stroke<'_>,
    ) {
        let mut list = String::new();
        for [x, y] in points {
            // Writing to a String cannot fail.
            let _ = write!(list, "{x:.1},{y:.1} ");
        }
        let Stroke { color, width, dash } = stroke;
        self.push(&format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\" \
             stroke-dasharray=\"{dash}\"/>",
            list.trim_end()
        ));
    }

    fn push(&mut self, element: &str) {
        self.0 += element;
        self.0.push('\n');
    }

    /// The whole file, on white, `height` pixels high.
    pub(crate) fn finish(&self, height: f64) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height:.0}\" \
             viewBox=\"0 0 {WIDTH} {height:.0}\" font-family=\"sans-serif\" fill=\"{INK}\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n{}</svg>\n",
            self.0
        )
    }
}

/// How a line looks.
pub(crate) struct Stroke<'a> {
    pub(crate) color: &'a str,
    /// Pixels.
    pub(crate) width: f64,
    /// Lengths of dashes and gaps, pixels; empty for a whole line.
    pub(crate) dash: &'a str,
}

/// Multiples of 1, 2 or 5 times a power of ten within `low..=high`, at most some `most` of them,
/// with the decimals that their labels need.
pub(crate) fn ticks(low: f64, high: f64, most: usize) -> (Vec<f64>, usize) {
    let raw = (high - low) / most as f64;
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= raw * 0.999);
    let step = step.unwrap_or(raw);
    let decimals = (0..9).find(|d| (step * 10f64.powi(*d)).fract().min(1.0) < 1e-6).unwrap_or(9);
    let first = (low / step - 1e-9).ceil();
    let count = ((high / step + 1e-9).floor() - first).max(0.0);
    let mut values = Vec::new();
    let mut i = 0.0;
    while i <= count {
        values.push((first + i) * step);
        i += 1.0;
    }
    (values, decimals.unsigned_abs() as usize)
}

/// The largest of 1, 2 or 5 times a power of ten that is not above `x`, which is positive.
pub(crate) fn round_below(x: f64) -> f64 {
    let power = 10f64.powf(x.log10().floor());
    [5.0, 2.0, 1.0].map(|m| m * power).into_iter().find(|v| *v <= x * 1.001).unwrap_or(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        let (values, decimals) = ticks(0.0, 0.2, 5);
        assert_eq!((values.len(), decimals), (5, 2));
        assert!((values[4] - 0.2).abs() < 1e-15, "{values:?}");
        assert_eq!(ticks(-3.0, 12.0, 4), (vec![0.0, 5.0, 10.0], 0));
        assert_eq!(ticks(0.0, 50.0, 6), (vec![0.0, 10.0, 20.0, 30.0, 40.0, 50.0], 0));
    }

    #[test]
    fn bars_are_round() {
        for (x, bar) in [(0.13, 0.1), (0.2, 0.2), (4.9, 2.0), (70.0, 50.0)] {
            assert!((round_below(x) / bar - 1.0).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn a_drawing_is_balanced_and_escaped() {
        let mut canvas = Canvas::default();
        canvas.text([1.0, 2.0], 12.0, Anchor::Middle, "a < b & c");
        let red = Stroke { color: "red", width: 1.0, dash: "" };
        canvas.polyline([[0.0, 1.25], [2.0, 3.0]], &red);
        let svg = canvas.finish(100.0);
        assert!(svg.contains("a &lt; b &amp; c</text>"), "{svg}");
        assert!(svg.contains("points=\"0.0,1.2 2.0,3.0\""), "{svg}");
        assert_eq!(svg.matches('<').count(), svg.matches('>').count());
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"), "{svg}");
    }
}
