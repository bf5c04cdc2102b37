//! Cem Yuksel's binary hair format: little endian, single precision, a header of 128 bytes. It
//! holds strands and nothing else: no objects, no velocities.
//!
//! After the header come the segment counts (`u16`), the points (three `f32` each) and the
//! thicknesses (`f32`), which are diameters. Lengths are in metres; readers that expect another
//! unit have a scale.

use super::{ExportError, Frame};
use crate::single::write_single;
use std::io::Write;

/// Flags of the arrays that follow the header: bit 0 segments, bit 1 points, bit 2 thickness.
const ARRAYS: u32 = 0b111;

/// Largest number of segments of a strand that the format can hold.
pub const MOST_SEGMENTS: usize = u16::MAX as usize;

/// Writes the strands of `frame`.
///
/// # Errors
/// Refuses invalid frames and strands of more than [`MOST_SEGMENTS`], and numbers beyond single
/// precision; fails if `out` does.
pub fn write(out: &mut impl Write, frame: &Frame) -> Result<(), ExportError> {
    frame.validate()?;
    out.write_all(&header(frame)?)?;
    for strand in &frame.strands {
        let segments = strand.frames.len();
        let count = u16::try_from(segments)
            .map_err(|_| too_many("segments in a strand", segments, MOST_SEGMENTS))?;
        out.write_all(&count.to_le_bytes())?;
    }
    for x in frame.strands.iter().flat_map(|s| &s.points).flat_map(|p| p.coords.iter()) {
        write_single(out, *x)?;
    }
    for radius in frame.strands.iter().flat_map(|s| &s.radii) {
        write_single(out, 2.0 * radius)?;
    }
    Ok(())
}

fn header(frame: &Frame) -> Result<[u8; 128], ExportError> {
    let count = |what, n: usize| u32::try_from(n).map_err(|_| too_many(what, n, u32::MAX as usize));
    let mut bytes = [0; 128];
    let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    put(0, b"HAIR");
    put(4, &count("strands", frame.strands.len())?.to_le_bytes());
    put(8, &count("points", frame.points())?.to_le_bytes());
    put(12, &ARRAYS.to_le_bytes());
    // Defaults for arrays that are missing: segments 0, thickness 0, transparency 0, a brown.
    for (i, channel) in [0.35_f32, 0.25, 0.15].iter().enumerate() {
        put(28 + 4 * i, &channel.to_le_bytes());
    }
    let mut info = format!("Rapunzel, frame {} at {} s, in metres", frame.index, frame.time);
    info.truncate(87);
    put(40, info.as_bytes());
    Ok(bytes)
}

fn too_many(what: &'static str, found: usize, limit: usize) -> ExportError {
    ExportError::TooMany { what, found, limit }
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;
    use crate::single::narrowed;

    fn u32_at(bytes: &[u8], at: usize) -> u32 {
        u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
    }

    #[test]
    fn bytes_are_where_the_format_has_them() {
        let frame = sample::frame(3);
        let mut bytes = Vec::new();
        write(&mut bytes, &frame).expect("memory");
        assert_eq!(&bytes[..4], b"HAIR");
        assert_eq!([4, 8, 12].map(|at| u32_at(&bytes, at)), [3, 27, 7]);
        assert_eq!(&bytes[40..57], b"Rapunzel, frame 3");
        assert_eq!(bytes[127], 0, "the text ends with a zero");
        assert_eq!(&bytes[128..134], &[5, 0, 8, 0, 11, 0]);
        assert_eq!(bytes.len(), 128 + 3 * 2 + 27 * 12 + 27 * 4);
        let point = frame.strands[1].points[2];
        let at = 134 + 12 * (6 + 2);
        assert_eq!(f32::from_bits(u32_at(&bytes, at)), narrowed(point.x).expect("small"));
        assert_eq!(f32::from_bits(u32_at(&bytes, at + 8)), narrowed(point.z).expect("small"));
        let last = f32::from_bits(u32_at(&bytes, bytes.len() - 4));
        assert_eq!(last, narrowed(2.0 * frame.strands[2].radii[11]).expect("small"));
    }

    #[test]
    fn a_strand_too_long_for_the_format_is_refused() {
        let mut frame = sample::frame(0);
        let strand = &mut frame.strands[0];
        strand.points = vec![strand.points[0]; 70_001];
        strand.radii = vec![1e-5; 70_001];
        strand.velocities = vec![strand.velocities[0]; 70_001];
        strand.curvatures = vec![strand.curvatures[0]; 70_001];
        strand.frames = vec![strand.frames[0]; 70_000];
        strand.forces = vec![strand.forces[0]; 70_000];
        strand.contact_forces = vec![strand.contact_forces[0]; 70_001];
        strand.charges = vec![0.0; 70_001];
        let error = write(&mut Vec::new(), &frame).expect_err("65535 segments at most");
        assert!(matches!(error, ExportError::TooMany { found: 70_000, limit: 65_535, .. }));
    }
}
