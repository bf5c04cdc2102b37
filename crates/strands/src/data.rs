//! The binary format of USC-HairSalon: the number of strands, then for each its number of points
//! and the points.

use crate::StrandsError;
use crate::bytes::{ByteReader, triples};
use crate::raw::RawStrands;

pub(crate) const NAME: &str = "DATA";

pub(crate) fn read(bytes: &[u8]) -> Result<RawStrands, StrandsError> {
    let mut raw = RawStrands::default();
    raw.points.reserve(bytes.len() / 12);
    walk(bytes, |points| {
        raw.counts.push(points.len() / 12);
        raw.points.extend(triples(points));
    })?;
    Ok(raw)
}

/// Whether the counts lead to the end of the file.
pub(crate) fn is_likely(bytes: &[u8]) -> bool {
    walk(bytes, |_| ()).is_ok_and(|strands| strands > 0)
}

/// Calls `see` with the points of every strand; returns their number.
fn walk<'a>(bytes: &'a [u8], mut see: impl FnMut(&'a [u8])) -> Result<i32, StrandsError> {
    let mut reader = ByteReader::new(NAME, bytes);
    let strands = i32::from_le_bytes(reader.array("number of strands")?);
    if strands < 0 {
        return Err(reader.refuse(format!("{strands} strands; it is no .data file")));
    }
    for strand in 0..strands {
        let count = i32::from_le_bytes(reader.array("number of points of a strand")?);
        let Ok(count) = u64::try_from(count) else {
            return Err(reader.refuse(format!("strand {strand} has {count} points")));
        };
        see(reader.take("points of a strand", count, 12)?);
    }
    if reader.left() > 0 {
        return Err(reader.refuse(format!("it goes on after its {strands} strands")));
    }
    Ok(strands)
}
