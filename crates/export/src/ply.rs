//! PLY as a set of points, as text or binary: the points of all strands in rows (`x`, `y`, `z` and
//! `radius`, `f32`, m), one strand after the other.
//!
//! How many points a strand has is in a comment `points_per_strand 100` where all have as many.
//! Otherwise an element `strand` has their numbers as its property `points`.

use super::{ExportError, Frame};
use crate::single::write_single;
use crate::text::single;
use std::io::Write;

/// How the numbers of a PLY are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlyEncoding {
    /// As text, with the fewest digits that read back the same.
    Text,
    /// Binary, little endian.
    Binary,
}

/// Writes the strands of `frame`.
///
/// # Errors
/// Refuses invalid frames, strands of more than 2³² - 1 points, and numbers beyond single
/// precision; fails if `out` does.
pub fn write(
    out: &mut impl Write,
    frame: &Frame,
    encoding: PlyEncoding,
) -> Result<(), ExportError> {
    frame.validate()?;
    let counts = || frame.strands.iter().map(|strand| strand.points.len());
    let each = counts().next().filter(|&first| counts().all(|count| count == first));
    let name = match encoding {
        PlyEncoding::Text => "ascii",
        PlyEncoding::Binary => "binary_little_endian",
    };
    writeln!(out, "ply\nformat {name} 1.0")?;
    writeln!(out, "comment Rapunzel, frame {} at {} s, in meters", frame.index, frame.time)?;
    if let Some(each) = each {
        writeln!(out, "comment points_per_strand {each}")?;
    }
    writeln!(out, "element vertex {}", frame.points())?;
    for property in ["x", "y", "z", "radius"] {
        writeln!(out, "property float {property}")?;
    }
    if each.is_none() {
        writeln!(out, "element strand {}\nproperty uint points", frame.strands.len())?;
    }
    writeln!(out, "end_header")?;
    for strand in &frame.strands {
        for (point, &radius) in strand.points.iter().zip(&strand.radii) {
            let row = [point.x, point.y, point.z, radius];
            match encoding {
                PlyEncoding::Binary => row.iter().try_for_each(|x| write_single(out, *x))?,
                PlyEncoding::Text => {
                    for (x, end) in row.into_iter().zip([b" ", b" ", b" ", b"\n"]) {
                        single(out, x)?;
                        out.write_all(end)?;
                    }
                }
            }
        }
    }
    let limit = u32::MAX as usize;
    for found in counts().filter(|_| each.is_none()) {
        let what = "points in a strand";
        let count =
            u32::try_from(found).map_err(|_| ExportError::TooMany { what, found, limit })?;
        match encoding {
            PlyEncoding::Binary => out.write_all(&count.to_le_bytes())?,
            PlyEncoding::Text => writeln!(out, "{count}")?,
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    fn written(frame: &Frame, encoding: PlyEncoding) -> Vec<u8> {
        let mut bytes = Vec::new();
        write(&mut bytes, frame, encoding).expect("memory");
        bytes
    }

    #[test]
    fn the_head_tells_how_many_points_a_strand_has() {
        let mut frame = sample::frame(2);
        let text = String::from_utf8(written(&frame, PlyEncoding::Text)).expect("text");
        assert!(text.contains("element vertex 27\n") && text.contains("element strand 3\n"));
        assert!(text.ends_with("\n6\n9\n12\n") && !text.contains("points_per_strand"));
        frame.strands = vec![frame.strands[1].clone(); 4];
        let text = String::from_utf8(written(&frame, PlyEncoding::Text)).expect("text");
        assert!(text.contains("\ncomment points_per_strand 9\n") && !text.contains("strand 4"));
        assert_eq!(text.lines().count(), 10 + 36);
    }

    #[test]
    fn binary_rows_have_four_numbers() {
        let frame = sample::frame(2);
        let bytes = written(&frame, PlyEncoding::Binary);
        let end = b"end_header\n";
        let head = bytes.windows(end.len()).position(|w| w == end).expect("a head") + end.len();
        assert_eq!(bytes.len(), head + 27 * 16 + 3 * 4);
        let radius = f32::from_le_bytes(bytes[head + 12..head + 16].try_into().expect("four"));
        assert!((f64::from(radius) - frame.strands[0].radii[0]).abs() < 1e-11);
        assert_eq!(bytes[bytes.len() - 4..], 12_u32.to_le_bytes());
    }
}
