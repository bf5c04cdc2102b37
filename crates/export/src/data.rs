//! The binary format of USC-HairSalon, `.data`: little endian, the number of strands, then for each
//! its number of points (both `i32`) and the points (three `f32` each, m). It holds no radii.

use super::{ExportError, Frame};
use crate::single::write_single;
use std::io::Write;

/// Largest number of strands, and of points of one, that the format can hold.
pub const MOST_ITEMS: usize = i32::MAX as usize;

/// Writes the strands of `frame`.
///
/// # Errors
/// Refuses invalid frames, more than [`MOST_ITEMS`] strands or points of one, and numbers beyond
/// single precision; fails if `out` does.
pub fn write(out: &mut impl Write, frame: &Frame) -> Result<(), ExportError> {
    frame.validate()?;
    write_count(out, "strands", frame.strands.len())?;
    for strand in &frame.strands {
        write_count(out, "points in a strand", strand.points.len())?;
        for x in strand.points.iter().flat_map(|p| p.coords.iter()) {
            write_single(out, *x)?;
        }
    }
    Ok(())
}

fn write_count(out: &mut impl Write, what: &'static str, found: usize) -> Result<(), ExportError> {
    let count = i32::try_from(found).map_err(|_| ExportError::TooMany {
        what,
        found,
        limit: MOST_ITEMS,
    })?;
    Ok(out.write_all(&count.to_le_bytes())?)
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    #[test]
    fn bytes_are_where_the_format_has_them() {
        let frame = sample::frame(1);
        let mut bytes = Vec::new();
        write(&mut bytes, &frame).expect("memory");
        let count = |at: usize| i32::from_le_bytes(bytes[at..at + 4].try_into().expect("four"));
        // Three strands of 6, 9 and 12 points.
        assert_eq!([0, 4, 80, 192].map(count), [3, 6, 9, 12]);
        assert_eq!(bytes.len(), 4 + 3 * 4 + 27 * 12);
        let last = f32::from_le_bytes(bytes[bytes.len() - 4..].try_into().expect("four"));
        assert!((f64::from(last) - frame.strands[2].points[11].z).abs() < 2e-8);
    }

    #[test]
    fn what_single_precision_does_not_hold_is_refused() {
        let mut frame = sample::frame(0);
        frame.strands[0].points[1].y = 1e39;
        let error = write(&mut Vec::new(), &frame).expect_err("too large");
        assert!(matches!(error, ExportError::Single { value: 1e39 }), "{error}");
    }
}
