//! VTK poly data: one poly line per fibre, raw binary, double precision.
//!
//! Point data: `radius`, `velocity`, `curvature`, `contact_force`, `charge`, and the data of
//! segments, which VTK has no place for, as the value of the segment that begins at the point:
//! `d1`, `d2`, `d3`, `force` and `tension` (the last point of a fibre repeats its last segment).
//! Cell data: `fiber`. Field data: `TimeValue`, s, and `FrameIndex`.
//!
//! [`read()`] reads what [`write()`] wrote, to the last bit; [`Arrays`] reads single arrays.

mod arrays;
pub(super) mod read;
pub(super) mod write;

pub use arrays::{Arrays, VectorSource};
pub use read::read;
pub use write::write;
pub use write::write_strands;

/// Text after the raw data; a file without it is cut short.
pub(super) const END: &[u8] = b"\n  </AppendedData>\n</VTKFile>\n";

/// Names and components of the point data, in the order in which they are stored; positions come
/// before them, connectivity, offsets and fibre numbers after them.
const POINT_DATA: [(&str, usize); 10] = [
    ("radius", 1),
    ("velocity", 3),
    ("curvature", 3),
    ("d1", 3),
    ("d2", 3),
    ("d3", 3),
    ("force", 3),
    ("tension", 1),
    ("contact_force", 3),
    ("charge", 1),
];

#[cfg(test)]
mod tests {
    use super::super::{ExportError, Frame, sample};
    use super::*;
    use std::io::Cursor;

    fn bytes(frame: &Frame) -> Vec<u8> {
        let mut out = Cursor::new(Vec::new());
        write(&mut out, frame).expect("memory");
        out.into_inner()
    }

    #[test]
    fn a_frame_survives_to_the_last_bit() {
        for index in [0, 7] {
            let frame = sample::frame(index);
            assert_eq!(read(&mut bytes(&frame).as_slice()).expect("our own file"), frame);
        }
        let none = Frame { index: 3, time: 0.1, strands: vec![] };
        assert_eq!(read(&mut bytes(&none).as_slice()).expect("an empty frame"), none);
    }

    #[test]
    fn offsets_point_at_the_size_of_each_array() {
        let frame = sample::frame(1);
        let bytes = bytes(&frame);
        let start = bytes.windows(2).position(|w| w == b"\n_").expect("the appended data") + 2;
        let header = std::str::from_utf8(&bytes[..start]).expect("text");
        let points = frame.points();
        let sizes = [3, 1, 3, 3, 3, 3, 3, 3, 1, 3, 1].map(|n| 8 * n * points);
        let mut offset = 0;
        for size in sizes.into_iter().chain([8 * points, 8 * 3, 8 * 3]) {
            assert!(header.contains(&format!("offset=\"{offset}\"")), "{offset} in {header}");
            let at = start + offset;
            let written = u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"));
            assert_eq!(usize::try_from(written).expect("a size"), size);
            offset += 8 + size;
        }
        assert!(bytes[start + offset..].starts_with(b"\n"), "nothing after the last array");
    }

    #[test]
    fn tension_is_the_force_along_the_tangent() {
        let frame = sample::frame(1);
        let bytes = bytes(&frame);
        let start = bytes.windows(2).position(|w| w == b"\n_").expect("the appended data") + 2;
        let before: usize =
            [3, 1, 3, 3, 3, 3, 3, 3].iter().map(|n| 8 + 8 * n * frame.points()).sum();
        let at = start + before + 8;
        let tension = f64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"));
        let strand = &frame.strands[0];
        let tangent = strand.frames[0].matrix().column(2).into_owned();
        assert_eq!(tension, strand.forces[0].dot(&tangent));
    }

    #[test]
    fn damage_is_an_error_not_a_panic() {
        let whole = bytes(&sample::frame(0));
        for length in (0..whole.len()).step_by(97) {
            assert!(read(&mut &whole[..length]).is_err(), "cut to {length} bytes");
        }
        // A size, a count or an offset that lies.
        for (from, to) in [
            ("NumberOfPoints=\"27\"", "NumberOfPoints=\"28\""),
            ("NumberOfPoints=\"27\"", "NumberOfPoints=\"99999999999999999\""),
            ("NumberOfLines=\"3\"", "NumberOfLines=\"2\""),
            ("Name=\"d2\"", "Name=\"d9\""),
        ] {
            let at = whole.windows(from.len()).position(|w| w == from.as_bytes()).expect("there");
            let mut bad = whole.clone();
            bad.splice(at..at + from.len(), to.bytes());
            let error = read(&mut bad.as_slice()).expect_err(to);
            assert!(matches!(error, ExportError::Malformed { .. } | ExportError::Io(_)), "{error}");
        }
    }
}
