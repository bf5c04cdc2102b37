use super::check;
use crate::export::ExportError;
use crate::export::usda::{list, rate, triple};
use rapunzel_collision::field::Soup;
use std::io::Write;

/// Writes the surfaces of `frames`, one for each of `times` (s), as one USD `Mesh` in text form:
/// metres, z up, a time code for each frame, points in single precision. A single one is still.
///
/// # Errors
/// Refuses an empty series, times that are not evenly spaced or not as many as the frames, triangles
/// that change, and surfaces that are not finite; passes on errors of `frames` and `out`.
pub fn write(
    out: &mut impl Write,
    times: &[f64],
    frames: impl IntoIterator<Item = Result<Soup, ExportError>>,
) -> Result<(), ExportError> {
    let (rate, last) = (rate(times)?, times.len().saturating_sub(1));
    let mut frames = frames.into_iter();
    let first = frames.next().ok_or(ExportError::Empty)??;
    write!(
        out,
        r#"#usda 1.0
(
    defaultPrim = "Objects"
    endTimeCode = {last}
    metersPerUnit = 1
    startTimeCode = 0
    timeCodesPerSecond = {rate}
    upAxis = "Z"
)

def Xform "Objects" (
    kind = "component"
)
{{
    def Mesh "Surfaces"
    {{
        uniform token subdivisionScheme = "none"
        int[] faceVertexCounts = "#
    )?;
    list(out, first.triangles.iter().map(|_| "3".to_owned()))?;
    write!(out, "\n        int[] faceVertexIndices = ")?;
    list(out, first.triangles.iter().flatten().map(ToString::to_string))?;
    if last == 0 {
        check(&first)?;
        write!(out, "\n        point3f[] points = ")?;
        list(out, first.vertices.iter().map(triple))?;
        writeln!(out, "\n    }}\n}}")?;
        return Ok(());
    }
    writeln!(out, "\n        point3f[] points.timeSamples = {{")?;
    let triangles = first.triangles.clone();
    let mut count = 0;
    for (index, frame) in std::iter::once(Ok(first)).chain(frames).enumerate() {
        let frame = frame?;
        check(&frame)?;
        if index > last || frame.triangles != triangles {
            let what = "there are more surfaces than times, or their triangles have changed";
            return Err(ExportError::Series { index, what });
        }
        write!(out, "            {index}: ")?;
        list(out, frame.vertices.iter().map(triple))?;
        writeln!(out, ",")?;
        count += 1;
    }
    if count != times.len() {
        return Err(ExportError::Series { index: count, what: "it is missing" });
    }
    writeln!(out, "        }}\n    }}\n}}")?;
    Ok(())
}
