use super::{END, POINT_DATA};
use crate::{ExportError, Frame, Strand};
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use std::io::{BufRead, Read};

/// Reads a frame that [`super::write`] wrote; other VTK files are refused.
///
/// # Errors
/// [`ExportError::Malformed`] or [`ExportError::Io`] for anything else, also where it is cut short.
pub fn read(input: &mut impl BufRead) -> Result<Frame, ExportError> {
    let header = header(input)?;
    let time = number(field(&header, "Name=\"TimeValue\"", ">", "<")?)?;
    let index = number(field(&header, "Name=\"FrameIndex\"", ">", "<")?)?;
    let points: usize = number(field(&header, "<Piece", "NumberOfPoints=\"", "\"")?)?;
    let lines: usize = number(field(&header, "<Piece", "NumberOfLines=\"", "\"")?)?;
    if POINT_DATA.iter().any(|(name, _)| !header.contains(&format!("Name=\"{name}\""))) {
        return Err(ExportError::Malformed { what: "an array of point data is missing" });
    }

    let positions = block(input, 3, points)?;
    let mut data = Vec::new();
    for (_, parts) in POINT_DATA {
        data.push(block(input, parts, points)?);
    }
    block(input, 1, points)?;
    let ends = block(input, 1, lines)?;
    block(input, 1, lines)?;
    ended(input)?;

    let mut strands = Vec::new();
    let mut first = 0;
    for end in ends {
        let end = usize::try_from(u64::from_le_bytes(end))
            .ok()
            .filter(|&end| end <= points && end >= first + 2)
            .ok_or(ExportError::Malformed { what: "the ends of the lines are out of order" })?;
        strands.push(strand(&positions, &data, first, end));
        first = end;
    }
    if first != points {
        return Err(ExportError::Malformed { what: "the lines do not hold all points" });
    }
    let frame = Frame { index, time, strands };
    frame.validate()?;
    Ok(frame)
}

/// Checks that only the end of the file follows.
pub(crate) fn ended(input: &mut impl BufRead) -> Result<(), ExportError> {
    let mut end = Vec::new();
    input.take(END.len() as u64 + 1).read_to_end(&mut end)?;
    if end == END {
        return Ok(());
    }
    Err(ExportError::Malformed { what: "the file does not end after its last array" })
}

/// The text up to the mark of the appended data.
pub(crate) fn header(input: &mut impl BufRead) -> Result<String, ExportError> {
    const LONGEST: u64 = 1 << 16;
    let mut bytes = Vec::new();
    let mut limited = input.take(LONGEST);
    while !bytes.ends_with(b"<AppendedData encoding=\"raw\">\n") {
        if limited.read_until(b'\n', &mut bytes)? == 0 {
            return Err(ExportError::Malformed { what: "no raw appended data" });
        }
    }
    let mut mark = [0];
    input.read_exact(&mut mark)?;
    if mark != *b"_" {
        return Err(ExportError::Malformed { what: "no mark before the appended data" });
    }
    String::from_utf8(bytes).map_err(|_| ExportError::Malformed { what: "the header is no text" })
}

/// The text between `open` and `close`, after the first `anchor`.
pub(crate) fn field<'a>(
    header: &'a str,
    anchor: &str,
    open: &str,
    close: &str,
) -> Result<&'a str, ExportError> {
    let after = |text: &'a str, mark: &str| text.split_once(mark).map(|(_, rest)| rest);
    after(header, anchor)
        .and_then(|rest| after(rest, open))
        .and_then(|rest| rest.split_once(close))
        .map(|(inside, _)| inside)
        .ok_or(ExportError::Malformed { what: "a count or a time is missing in the header" })
}

pub(crate) fn number<T: std::str::FromStr>(text: &str) -> Result<T, ExportError> {
    text.parse().map_err(|_| ExportError::Malformed { what: "a number in the header" })
}

/// Reads one array of `parts * count` numbers of eight bytes, after its size.
pub(crate) fn block(
    input: &mut impl Read,
    parts: usize,
    count: usize,
) -> Result<Vec<[u8; 8]>, ExportError> {
    let mut size = [0; 8];
    input.read_exact(&mut size)?;
    let size = u64::from_le_bytes(size);
    let expected = count.checked_mul(8 * parts).map(|n| n as u64);
    if Some(size) != expected {
        return Err(ExportError::Malformed { what: "an array has another size than its points" });
    }
    // Grows with what is there, so that a size that lies cannot ask for memory.
    let mut bytes = Vec::new();
    input.take(size).read_to_end(&mut bytes)?;
    if bytes.len() as u64 != size {
        return Err(ExportError::Malformed { what: "the file is cut short" });
    }
    Ok(bytes.as_chunks().0.to_vec())
}

/// The strand between the points `first` and `end`.
fn strand(positions: &[[u8; 8]], data: &[Vec<[u8; 8]>], first: usize, end: usize) -> Strand {
    let vector =
        |array: &[[u8; 8]], i: usize| Vector3::from_fn(|k, _| f64::from_le_bytes(array[3 * i + k]));
    let vectors =
        |array: usize, end: usize| (first..end).map(|i| vector(&data[array], i)).collect();
    let numbers = |array: usize| {
        data[array][first..end].iter().map(|x| f64::from_le_bytes(*x)).collect::<Vec<_>>()
    };
    let frame = |i: usize| {
        let directors = [3, 4, 5].map(|array| vector(&data[array], i));
        Rotation3::from_matrix_unchecked(Matrix3::from_columns(&directors))
    };
    Strand {
        points: (first..end).map(|i| Point3::from(vector(positions, i))).collect(),
        radii: numbers(0),
        velocities: vectors(1, end),
        curvatures: vectors(2, end),
        frames: (first..end - 1).map(frame).collect(),
        forces: vectors(6, end - 1),
        contact_forces: vectors(8, end),
        charges: numbers(9),
    }
}
