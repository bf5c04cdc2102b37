//! POV-Ray scene description: a `#declare` of all fibres, to be included in a scene.
//!
//! POV-Ray is left-handed with y up, and its tolerances are made for scenes of unit size: points
//! are written as `<x, z, y>`, which keeps what is right on the right, and in millimetres.

use super::{ExportError, Frame};
use std::io::Write;

/// Millimetres per metre.
const SCALE: f64 = 1e3;

/// Writes `frame` as the object `Hair`, one sphere sweep per fibre. Use it by
/// `#include "frame.inc"` and `object { Hair texture { ... } }`.
///
/// # Errors
/// Refuses unsound and empty frames; fails if `out` does.
pub fn write(out: &mut impl Write, frame: &Frame) -> Result<(), ExportError> {
    frame.validate()?;
    if frame.strands.is_empty() {
        return Err(ExportError::Empty);
    }
    writeln!(out, "// Frame {} at {} s, in millimetres, y up.", frame.index, frame.time)?;
    writeln!(out, "#declare Hair = union {{")?;
    for strand in &frame.strands {
        writeln!(out, "  sphere_sweep {{ linear_spline {}", strand.points.len())?;
        for (p, radius) in strand.points.iter().zip(&strand.radii) {
            let [x, y, z] = [p.x, p.z, p.y].map(|x| SCALE * x);
            writeln!(out, "    <{x:.6}, {y:.6}, {z:.6}>, {:.6}", SCALE * radius)?;
        }
        writeln!(out, "  }}")?;
    }
    writeln!(out, "}}")?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    #[test]
    fn every_point_is_a_sphere() {
        let frame = sample::frame(2);
        let mut out = Vec::new();
        write(&mut out, &frame).expect("memory");
        let text = String::from_utf8(out).expect("text");
        assert_eq!(text.matches("sphere_sweep").count(), 3);
        assert_eq!(text.matches('<').count(), frame.points());
        assert_eq!(text.matches('{').count(), text.matches('}').count());
        let p = frame.strands[0].points[5];
        let line = format!("<{:.6}, 300.000000, {:.6}>", 1e3 * p.x, 1e3 * p.y);
        assert!(text.contains(&line), "{line} not in {text}");
    }

    #[test]
    fn no_fiber_is_no_object() {
        let frame = Frame { index: 0, time: 0.0, strands: vec![] };
        assert!(matches!(write(&mut Vec::new(), &frame), Err(ExportError::Empty)));
    }
}
