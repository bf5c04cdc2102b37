//! A ParaView collection: the times of a series of files.

use super::ExportError;
use crate::text::escaped;
use std::io::Write;

/// Writes the collection of `files`, each a time in seconds, the number of a part that is shown
/// together with the others of that time, and the file's name relative to the folder of the
/// collection.
///
/// # Errors
/// If `out` fails.
pub fn write<'a>(
    out: &mut impl Write,
    files: impl IntoIterator<Item = (f64, u32, &'a str)>,
) -> Result<(), ExportError> {
    writeln!(out, r#"<?xml version="1.0"?>"#)?;
    writeln!(out, r#"<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">"#)?;
    writeln!(out, "  <Collection>")?;
    for (time, part, file) in files {
        let file = escaped(file);
        writeln!(out, r#"    <DataSet timestep="{time}" part="{part}" file="{file}"/>"#)?;
    }
    writeln!(out, "  </Collection>\n</VTKFile>")?;
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_file_has_its_time() {
        let mut out = Vec::new();
        super::write(&mut out, [(0.0, 0, "a.vtp"), (0.1, 2, "b&\".vtp")]).expect("memory");
        let text = String::from_utf8(out).expect("text");
        assert!(text.contains(r#"timestep="0" part="0" file="a.vtp""#), "{text}");
        assert!(text.contains(r#"timestep="0.1" part="2" file="b&amp;&quot;.vtp""#), "{text}");
    }
}
