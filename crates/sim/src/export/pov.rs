//! POV-Ray scene description: a `#declare` of all fibres, to be included in a scene.
//!
//! POV-Ray is left-handed with y up, and its tolerances are made for scenes of unit size: points
//! are written as `<x, z, y>`, which keeps what is right on the right, and in millimetres.

use super::{ExportError, Frame};
use std::io::Write;

/// Millimetres per metre.
const SCALE: f64 = 1e3;

/// Writes `frame` as the object `Hair`, a cone per segment: POV-Ray finds its way through many
/// small objects far sooner than along one long sphere sweep. Use it by `#include "frame.inc"` and
/// `object { Hair texture { ... } }`.
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
        let place = |i: usize| {
            let [x, y, z] = strand.points[i].coords.data.0[0].map(|x| SCALE * x);
            format!("<{x:.6}, {z:.6}, {y:.6}>")
        };
        for j in 0..strand.frames.len() {
            let (a, b) = (place(j), place(j + 1));
            let [thick, thin] = [j, j + 1].map(|i| SCALE * strand.radii[i]);
            // POV-Ray stops at a cone without length.
            if a != b {
                writeln!(out, "  cone {{ {a}, {thick:.6}, {b}, {thin:.6} }}")?;
            }
        }
    }
    writeln!(out, "}}")?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    #[test]
    fn every_segment_is_a_cone() {
        let frame = sample::frame(2);
        let mut out = Vec::new();
        write(&mut out, &frame).expect("memory");
        let text = String::from_utf8(out).expect("text");
        assert_eq!(text.matches("cone").count(), 5 + 8 + 11);
        assert_eq!(text.matches('{').count(), text.matches('}').count());
        let p = frame.strands[0].points[5];
        let line = format!("<{:.6}, 300.000000, {:.6}>", 1e3 * p.x, 1e3 * p.y);
        assert!(text.contains(&line), "{line} not in {text}");
    }

    #[test]
    fn a_segment_without_length_is_left_out() {
        let mut frame = sample::frame(0);
        frame.strands[0].points[3] = frame.strands[0].points[2];
        let mut out = Vec::new();
        write(&mut out, &frame).expect("memory");
        assert_eq!(String::from_utf8(out).expect("text").matches("cone").count(), 23);
    }

    #[test]
    fn no_fiber_is_no_object() {
        let frame = Frame { index: 0, time: 0.0, strands: vec![] };
        assert!(matches!(write(&mut Vec::new(), &frame), Err(ExportError::Empty)));
    }
}
