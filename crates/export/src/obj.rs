//! Wavefront OBJ: the points of all strands (m), and a line for each strand. It holds no radii.

use super::{ExportError, Frame};
use crate::text::single;
use std::io::Write;

/// Writes the strands of `frame` as lines, with the fewest digits that read back the same in single
/// precision.
///
/// # Errors
/// Refuses invalid frames and numbers beyond single precision; fails if `out` does.
pub fn write(out: &mut impl Write, frame: &Frame) -> Result<(), ExportError> {
    frame.validate()?;
    writeln!(out, "# Rapunzel, frame {} at {} s, in meters", frame.index, frame.time)?;
    for point in frame.strands.iter().flat_map(|strand| &strand.points) {
        out.write_all(b"v")?;
        for x in &point.coords {
            out.write_all(b" ")?;
            single(out, *x)?;
        }
        out.write_all(b"\n")?;
    }
    // Points are numbered from one.
    let mut first = 1;
    for strand in &frame.strands {
        out.write_all(b"l")?;
        for number in first..first + strand.points.len() {
            write!(out, " {number}")?;
        }
        out.write_all(b"\n")?;
        first += strand.points.len();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    #[test]
    fn every_strand_is_a_line_over_its_own_points() {
        let frame = sample::frame(1);
        let mut bytes = Vec::new();
        write(&mut bytes, &frame).expect("memory");
        let text = String::from_utf8(bytes).expect("text");
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines.len(), 1 + 27 + 3);
        assert_eq!(lines[28], "l 1 2 3 4 5 6");
        assert_eq!(lines[29], "l 7 8 9 10 11 12 13 14 15");
        let numbers: Vec<f32> =
            lines[6].split(' ').skip(1).map(|x| x.parse().expect("a number")).collect();
        let point = frame.strands[0].points[5];
        for (axis, x) in numbers.into_iter().enumerate() {
            assert!((f64::from(x) - point[axis]).abs() < 2e-8);
        }
    }
}
