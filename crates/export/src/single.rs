use crate::ExportError;
use std::io::Write;

/// The nearest number in single precision.
#[expect(clippy::cast_possible_truncation, reason = "formats are in single precision")]
pub(crate) fn narrowed(value: f64) -> Result<f32, ExportError> {
    let narrow = value as f32;
    if narrow.is_finite() { Ok(narrow) } else { Err(ExportError::Single { value }) }
}

/// Writes a number in single precision, little endian.
pub(crate) fn write_single(out: &mut impl Write, value: f64) -> Result<(), ExportError> {
    Ok(out.write_all(&narrowed(value)?.to_le_bytes())?)
}
