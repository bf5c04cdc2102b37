//! Cem Yuksel's binary format: a header of 128 bytes, then arrays as its flags tell.

use crate::StrandsError;
use crate::bytes::{ByteReader, singles, triples};
use crate::raw::RawStrands;

pub(crate) const NAME: &str = "HAIR";

/// First bytes of a file.
pub(crate) const MARK: &[u8] = b"HAIR";

/// Size of the header, bytes.
const HEADER: u64 = 128;

/// Flags of the arrays that follow the header.
const SEGMENTS: u32 = 1;
const POINTS: u32 = 2;
const THICKNESS: u32 = 4;
const TRANSPARENCY: u32 = 8;
const COLORS: u32 = 16;

pub(crate) fn read(bytes: &[u8]) -> Result<RawStrands, StrandsError> {
    let mut header = ByteReader::new(NAME, bytes);
    if header.take("mark", 1, MARK.len())? != MARK {
        return Err(header.refuse("the mark HAIR is missing"));
    }
    let strands = header.u32("number of strands")?;
    let count = header.u32("number of points")?;
    let flags = header.u32("flags")?;
    let segments = header.u32("default segments")?;
    let thickness = header.f32("default thickness")?;
    if flags & POINTS == 0 {
        return Err(header.refuse("its flags tell that there are no points"));
    }
    ByteReader::new(NAME, bytes).take("header", HEADER, 1)?;

    // What follows is as long as the flags and counts tell, before anything is made of it.
    let mut arrays = header.seek(HEADER)?;
    let own = if flags & SEGMENTS == 0 { 0 } else { strands };
    let own = arrays.take("segments", own.into(), 2)?;
    let points = arrays.take("points", count.into(), 12)?;
    let mut optional = |flag, what, size| {
        let count = if flags & flag == 0 { 0 } else { count };
        arrays.take(what, count.into(), size)
    };
    let widths = optional(THICKNESS, "thicknesses", 4)?;
    optional(TRANSPARENCY, "transparencies", 4)?;
    optional(COLORS, "colors", 12)?;
    if arrays.left() > 0 {
        return Err(arrays.refuse("it goes on after all arrays of its header"));
    }

    let needed = if flags & SEGMENTS == 0 {
        u64::from(strands) * (u64::from(segments) + 1)
    } else {
        own.as_chunks().0.iter().map(|&two| u64::from(u16::from_le_bytes(two)) + 1).sum()
    };
    if needed != u64::from(count) {
        let problem = format!("{strands} strands should have {needed} points, but it has {count}");
        return Err(header.refuse(problem));
    }
    let counts = if flags & SEGMENTS == 0 {
        vec![segments as usize + 1; strands as usize]
    } else {
        own.as_chunks().0.iter().map(|&two| usize::from(u16::from_le_bytes(two)) + 1).collect()
    };
    let widths = if flags & THICKNESS != 0 {
        singles(widths).collect()
    } else if thickness > 0.0 {
        vec![thickness; count as usize]
    } else {
        Vec::new()
    };
    Ok(RawStrands { counts, points: triples(points).collect(), widths, ..RawStrands::default() })
}
