//! Packed bytes and integers of the binary form: blocks of LZ4, and differences in few bits.

use super::marks::NAME;
use crate::StrandsError;
use crate::bytes::ByteReader;

/// Most bytes that a byte of LZ4 unpacks to.
const RATIO: usize = 255;

/// Reads the size of packed bytes and unpacks these, to at most `most`.
pub(super) fn unpacked(at: &mut ByteReader<'_>, most: u64) -> Result<Vec<u8>, StrandsError> {
    let size = at.u64("size of packed bytes")?;
    let mut packed = ByteReader::new(NAME, at.take("packed bytes", size, 1)?);
    let most = usize::try_from(most).unwrap_or(usize::MAX);
    let mut bytes = vec![0; most.min(packed.left().saturating_mul(RATIO))];
    let [chunks] = packed.array("number of packed chunks")?;
    let mut filled = 0;
    for _ in 0..chunks.max(1) {
        // One chunk has no size of its own.
        let left = packed.left() as u64;
        let size = if chunks == 0 { left } else { packed.u32("size of a chunk")?.into() };
        let chunk = packed.take("packed chunk", size, 1)?;
        filled += lz4_flex::block::decompress_into(chunk, &mut bytes[filled..])
            .map_err(|error| at.refuse(format!("packed bytes before this are damaged: {error}")))?;
    }
    bytes.truncate(filled);
    Ok(bytes)
}

/// Reads `count` packed integers of 32 bits: the commonest difference, two bits for each that tell
/// whether its difference is that or has 1, 2 or 4 bytes, and these bytes.
pub(super) fn integers(at: &mut ByteReader<'_>, count: u64) -> Result<Vec<u32>, StrandsError> {
    // Of whatever is counted here, every one takes more than a byte in other places of the file.
    let count = usize::try_from(count).unwrap_or(usize::MAX);
    if count > at.size() {
        return Err(at.refuse(format!("it tells of {count} items, more than it has bytes")));
    }
    let bytes = unpacked(at, (4 + count.div_ceil(4) + 4 * count) as u64)?;
    if count == 0 {
        return Ok(Vec::new());
    }
    let mut differences = ByteReader::new(NAME, &bytes);
    let common = differences.u32("common difference")?;
    let codes = differences.take("sizes of differences", count.div_ceil(4) as u64, 1)?;
    let mut last = 0_u32;
    (0..count)
        .map(|k| {
            let difference = match (codes[k / 4] >> (2 * (k % 4))) & 3 {
                0 => common,
                1 => i32::from(i8::from_le_bytes(differences.array("difference")?)).cast_unsigned(),
                2 => {
                    i32::from(i16::from_le_bytes(differences.array("difference")?)).cast_unsigned()
                }
                _ => differences.u32("difference")?,
            };
            last = last.wrapping_add(difference);
            Ok(last)
        })
        .collect()
}
