//! USD in text form: all frames in one `BasisCurves` prim, metres, z up.
//!
//! Points are in single precision, as the schema has them; widths are diameters. A time code is a
//! frame: `timeCodesPerSecond` comes from the times, which must be evenly spaced.

use super::{ExportError, Frame};
use nalgebra::Point3;
use std::io::Write;

/// How the points are joined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Curve {
    /// By straight lines: what was simulated.
    Linear,
    /// By Catmull-Rom splines through all points, up to both ends: smooth pictures.
    CatmullRom,
}

/// Writes the series of `frames`, one for each of `times` (s), in their order.
///
/// The frames are asked for one after another and not kept, so they may come from files. The
/// widths are those of the first frame.
///
/// # Errors
/// Refuses an empty series, times that are not evenly spaced or not those of the frames, strands
/// that come and go, and unsound frames; passes on errors of `frames` and `out`.
pub fn write(
    out: &mut impl Write,
    curve: Curve,
    times: &[f64],
    frames: impl IntoIterator<Item = Result<Frame, ExportError>>,
) -> Result<(), ExportError> {
    let rate = rate(times)?;
    let mut frames = frames.into_iter();
    let first = frames.next().ok_or(ExportError::Empty)??;
    let mut series = Series::new(times, &first)?;
    preamble(out, curve, times.len(), rate, &first)?;

    writeln!(out, "        point3f[] points.timeSamples = {{")?;
    series.sample(out, &first)?;
    for frame in frames {
        series.sample(out, &frame?)?;
    }
    writeln!(out, "        }}")?;
    series.finish(out)
}

/// Time codes per second of evenly spaced times, 1 for a single one.
pub(super) fn rate(times: &[f64]) -> Result<f64, ExportError> {
    let [start, .., end] = times else { return Ok(1.0) };
    let interval = (end - start) / (times.len() - 1) as f64;
    for (index, time) in times.iter().enumerate() {
        // Also catches a NaN. Frame times are sums of steps and carry their rounding.
        let off = time - (start + index as f64 * interval);
        if !(interval > 0.0 && off.abs() <= 1e-3 * interval) {
            return Err(ExportError::Series { index, what: "the times are not evenly spaced" });
        }
    }
    // A rate in whole numbers is one, in spite of that rounding.
    let rate = 1.0 / interval;
    Ok(if (rate - rate.round()).abs() < 1e-6 * rate { rate.round() } else { rate })
}

/// What the samples have in common, and the extents found on the way.
struct Series<'a> {
    times: &'a [f64],
    counts: Vec<usize>,
    widest: f64,
    extents: Vec<[Point3<f64>; 2]>,
}

impl<'a> Series<'a> {
    fn new(times: &'a [f64], first: &Frame) -> Result<Self, ExportError> {
        first.validate()?;
        if first.strands.is_empty() {
            return Err(ExportError::Empty);
        }
        let counts = first.strands.iter().map(|s| s.points.len()).collect();
        let widest = first.strands.iter().flat_map(|s| &s.radii).fold(0.0, |a: f64, r| a.max(*r));
        Ok(Self { times, counts, widest, extents: Vec::new() })
    }

    /// Writes one time sample of the points.
    fn sample(&mut self, out: &mut impl Write, frame: &Frame) -> Result<(), ExportError> {
        frame.validate()?;
        let index = self.extents.len();
        if self.times.get(index) != Some(&frame.time) {
            return Err(ExportError::Series { index, what: "its time is not the one announced" });
        }
        if !self.counts.iter().copied().eq(frame.strands.iter().map(|s| s.points.len())) {
            return Err(ExportError::Series { index, what: "strands or points have changed" });
        }
        let points = || frame.strands.iter().flat_map(|s| &s.points);
        write!(out, "            {index}: ")?;
        list(out, points().map(triple))?;
        writeln!(out, ",")?;
        let start = points().next().copied().unwrap_or_default();
        let extent = points().fold([start; 2], |[low, high], p| [low.inf(p), high.sup(p)]);
        self.extents.push(extent);
        Ok(())
    }

    /// Writes the extents, widened by the curves' width, and closes the prim.
    fn finish(self, out: &mut impl Write) -> Result<(), ExportError> {
        if self.extents.len() != self.times.len() {
            let index = self.extents.len();
            return Err(ExportError::Series { index, what: "it is missing" });
        }
        writeln!(out, "        float3[] extent.timeSamples = {{")?;
        for (index, [low, high]) in self.extents.iter().enumerate() {
            let width = nalgebra::Vector3::repeat(self.widest);
            let (low, high) = (triple(&(low - width)), triple(&(high + width)));
            writeln!(out, "            {index}: [{low}, {high}],")?;
        }
        writeln!(out, "        }}\n    }}\n}}")?;
        Ok(())
    }
}

/// Everything before the time samples.
fn preamble(
    out: &mut impl Write,
    curve: Curve,
    frames: usize,
    rate: f64,
    first: &Frame,
) -> Result<(), ExportError> {
    let last = frames.saturating_sub(1);
    write!(
        out,
        r#"#usda 1.0
(
    defaultPrim = "Hair"
    endTimeCode = {last}
    metersPerUnit = 1
    startTimeCode = 0
    timeCodesPerSecond = {rate}
    upAxis = "Z"
)

def Xform "Hair" (
    kind = "component"
)
{{
    def BasisCurves "Fibers"
    {{
"#
    )?;
    let (kind, wrap) = match curve {
        Curve::Linear => (r#"uniform token type = "linear""#, "nonperiodic"),
        Curve::CatmullRom => (
            "uniform token basis = \"catmullRom\"\n        uniform token type = \"cubic\"",
            "pinned",
        ),
    };
    writeln!(out, "        {kind}\n        uniform token wrap = \"{wrap}\"")?;
    write!(out, "        int[] curveVertexCounts = ")?;
    list(out, first.strands.iter().map(|s| s.points.len().to_string()))?;
    let mut radii = first.strands.iter().flat_map(|s| &s.radii);
    let thinnest = radii.clone().fold(f64::INFINITY, |a, r| a.min(*r));
    let uniform = radii.all(|r| *r == thinnest);
    write!(out, "\n        float[] widths = ")?;
    let widths = first.strands.iter().flat_map(|s| &s.radii).map(|r| single(2.0 * r).to_string());
    list(out, widths.take(if uniform { 1 } else { usize::MAX }))?;
    let interpolation = if uniform { "constant" } else { "vertex" };
    writeln!(out, " (\n            interpolation = \"{interpolation}\"\n        )")?;
    Ok(())
}

/// `[a, b, c]`.
pub(super) fn list(
    out: &mut impl Write,
    items: impl Iterator<Item = String>,
) -> Result<(), ExportError> {
    write!(out, "[")?;
    for (i, item) in items.enumerate() {
        write!(out, "{}{item}", if i == 0 { "" } else { ", " })?;
    }
    write!(out, "]")?;
    Ok(())
}

pub(super) fn triple(p: &Point3<f64>) -> String {
    format!("({}, {}, {})", single(p.x), single(p.y), single(p.z))
}

#[expect(clippy::cast_possible_truncation, reason = "the schema is in single precision")]
fn single(x: f64) -> f32 {
    x as f32
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    fn series(curve: Curve, frames: usize) -> String {
        let frames: Vec<Frame> = (0..frames).map(sample::frame).collect();
        let times: Vec<f64> = frames.iter().map(|f| f.time).collect();
        let mut out = Vec::new();
        write(&mut out, curve, &times, frames.into_iter().map(Ok)).expect("a series");
        String::from_utf8(out).expect("text")
    }

    #[test]
    fn counts_are_those_of_the_points() {
        let text = series(Curve::Linear, 4);
        assert!(text.contains("int[] curveVertexCounts = [6, 9, 12]"), "{text}");
        assert!(text.contains("timeCodesPerSecond = 30\n"), "{text}");
        assert!(text.contains("endTimeCode = 3\n"), "{text}");
        let (points, extents) = text.split_once("extent.timeSamples").expect("extents");
        for sample in 0..4 {
            let row = |part: &str| {
                let mark = format!("            {sample}: [");
                part.lines().find(|l| l.starts_with(&mark)).expect("a sample").matches('(').count()
            };
            assert_eq!((row(points), row(extents)), (27, 2));
        }
        let widths = text.lines().find(|l| l.contains("widths")).expect("widths");
        assert_eq!(widths.matches(',').count(), 26);
        assert!(text.contains("interpolation = \"vertex\""), "{text}");
    }

    #[test]
    fn one_width_is_constant_and_splines_are_pinned() {
        let mut frame = sample::frame(0);
        frame.strands.iter_mut().for_each(|s| s.radii.fill(35e-6));
        let mut out = Vec::new();
        write(&mut out, Curve::CatmullRom, &[0.0], [Ok(frame)]).expect("a series");
        let text = String::from_utf8(out).expect("text");
        assert!(text.contains("widths = [0.00007] (\n            interpolation = \"constant\""));
        assert!(text.contains("wrap = \"pinned\"") && text.contains("\"catmullRom\""), "{text}");
    }

    #[test]
    fn what_is_no_series_is_refused() {
        let go = |times: &[f64], frames: Vec<Frame>| {
            write(&mut Vec::new(), Curve::Linear, times, frames.into_iter().map(Ok))
        };
        let frames: Vec<Frame> = (0..3).map(sample::frame).collect();
        let times: Vec<f64> = frames.iter().map(|f| f.time).collect();
        assert!(matches!(go(&[], vec![]), Err(ExportError::Empty)));
        let uneven = [times[0], times[1], 0.5];
        assert!(matches!(go(&uneven, frames.clone()), Err(ExportError::Series { index: 1, .. })));
        let missing = go(&times, frames[..2].to_vec());
        assert!(matches!(missing, Err(ExportError::Series { index: 2, .. })));
        let mut other = frames.clone();
        other[1].strands.pop();
        assert!(matches!(go(&times, other), Err(ExportError::Series { index: 1, .. })));
        let mut late = frames;
        late[2].time += 1e-9;
        assert!(matches!(go(&times, late), Err(ExportError::Series { index: 2, .. })));
    }
}
