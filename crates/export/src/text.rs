//! Writers of numbers and lists as text, without a `String` for each.

use crate::ExportError;
use crate::single::narrowed;
use std::io::Write;

/// Writes `[a, b, c]`, each item by `write`.
pub(crate) fn list<W: Write, T>(
    out: &mut W,
    items: impl IntoIterator<Item = T>,
    mut write: impl FnMut(&mut W, T) -> Result<(), ExportError>,
) -> Result<(), ExportError> {
    out.write_all(b"[")?;
    for (i, item) in items.into_iter().enumerate() {
        if i > 0 {
            out.write_all(b", ")?;
        }
        write(out, item)?;
    }
    out.write_all(b"]")?;
    Ok(())
}

/// Writes a list of integers.
pub(crate) fn integers<W: Write>(
    out: &mut W,
    what: &'static str,
    items: impl IntoIterator<Item = usize>,
) -> Result<(), ExportError> {
    list(out, items, |out, found| {
        let limit = i32::MAX as usize;
        if found > limit {
            return Err(ExportError::TooMany { what, found, limit });
        }
        Ok(write!(out, "{found}")?)
    })
}

/// Writes three numbers in single precision.
pub(crate) fn triple(out: &mut impl Write, vector: [f64; 3]) -> Result<(), ExportError> {
    for (open, x) in [b"(", b",", b","].into_iter().zip(vector) {
        out.write_all(open)?;
        single(out, x)?;
    }
    out.write_all(b")")?;
    Ok(())
}

/// Writes a number in single precision, with the fewest digits that read back the same.
pub(crate) fn single(out: &mut impl Write, value: f64) -> Result<(), ExportError> {
    let mut buffer = zmij::Buffer::new();
    let text = buffer.format_finite(narrowed(value)?);
    out.write_all(text.strip_suffix(".0").unwrap_or(text).as_bytes())?;
    Ok(())
}

/// A text as the value of an attribute in XML.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
