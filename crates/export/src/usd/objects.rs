use super::{ROOT, Timeline, begin_prim, material};
use crate::ExportError;
use crate::surface::{COLOR, Placed};
use crate::text::{integers, list, triple};
use nalgebra::Isometry3;
use std::io::Write;

/// Writes a layer of objects, each a `Mesh` in its own frame that is moved by its transform.
///
/// `objects` are the objects of the first frame; `poses` has the poses of all objects in every
/// frame, or only in the first if they are at rest.
///
/// # Errors
/// [`ExportError::Empty`] without objects; [`ExportError::Series`] if poses are missing;
/// [`ExportError::Single`] for vertices beyond single precision; fails if `out` does.
pub fn write(
    out: &mut impl Write,
    timeline: &Timeline,
    objects: &[Placed],
    poses: &[Vec<Isometry3<f64>>],
) -> Result<(), ExportError> {
    if objects.is_empty() {
        return Err(ExportError::Empty);
    }
    if let Some(index) = poses.iter().position(|poses| poses.len() != objects.len()) {
        return Err(ExportError::Series { index, what: "it has other objects" });
    }
    if poses.len() != 1 && poses.len() != timeline.frames {
        return Err(ExportError::Series { index: poses.len(), what: "it is missing" });
    }
    let looks = format!("/{ROOT}/Objects/Looks");
    timeline.begin(out, "")?;
    writeln!(out, "\ndef Xform \"{ROOT}\"\n{{\n    def Xform \"Objects\"\n    {{")?;
    writeln!(out, "        def Scope \"Looks\"\n        {{")?;
    material(out, &looks, "Surface", COLOR)?;
    writeln!(out, "        }}")?;
    for (i, object) in objects.iter().enumerate() {
        begin_prim(out, "Mesh", &format!("Object_{i}"), &format!("{looks}/Surface"), COLOR)?;
        mesh(out, object)?;
        let poses: Vec<_> = poses.iter().map(|poses| poses[i]).collect();
        transform(out, timeline, &poses)?;
        writeln!(out, "        }}")?;
    }
    Ok(writeln!(out, "    }}\n}}")?)
}

/// Writes a surface in the object's own frame.
fn mesh(out: &mut impl Write, Placed { pose, surface }: &Placed) -> Result<(), ExportError> {
    let own: Vec<_> = surface.vertices.iter().map(|p| pose.inverse_transform_point(p)).collect();
    let low = own.iter().fold([f64::INFINITY; 3], |low, p| [0, 1, 2].map(|k| low[k].min(p[k])));
    let high =
        own.iter().fold([f64::NEG_INFINITY; 3], |high, p| [0, 1, 2].map(|k| high[k].max(p[k])));
    writeln!(out, "            uniform token subdivisionScheme = \"none\"")?;
    write!(out, "            int[] faceVertexCounts = ")?;
    integers(out, "vertices", surface.triangles.iter().map(|_| 3))?;
    write!(out, "\n            int[] faceVertexIndices = ")?;
    integers(out, "vertices", surface.triangles.iter().flatten().map(|&v| v as usize))?;
    write!(out, "\n            point3f[] points = ")?;
    list(out, own, |out, p| triple(out, p.into()))?;
    write!(out, "\n            float3[] extent = ")?;
    list(out, [low, high], triple)?;
    Ok(writeln!(out)?)
}

/// Writes the transform of an object: once if it is at rest.
fn transform(
    out: &mut impl Write,
    timeline: &Timeline,
    poses: &[Isometry3<f64>],
) -> Result<(), ExportError> {
    let places = poses.iter().map(|pose| {
        let [x, y, z] = pose.translation.vector.into();
        format!("({x}, {y}, {z})")
    });
    let turns = poses.iter().map(|pose| {
        let [i, j, k, w] = pose.rotation.coords.into();
        format!("({w}, {i}, {j}, {k})")
    });
    values(out, timeline, "double3 xformOp:translate", places.collect())?;
    values(out, timeline, "quatd xformOp:orient", turns.collect())?;
    let order = r#"uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"]"#;
    Ok(writeln!(out, "            {order}")?)
}

/// Writes an attribute over the frames: one value if all are the same.
fn values(
    out: &mut impl Write,
    timeline: &Timeline,
    attribute: &str,
    values: Vec<String>,
) -> Result<(), ExportError> {
    if values.iter().all(|value| *value == values[0]) {
        return Ok(writeln!(out, "            {attribute} = {}", values[0])?);
    }
    writeln!(out, "            {attribute}.timeSamples = {{")?;
    for (frame, value) in values.iter().enumerate() {
        writeln!(out, "                {}: {value},", timeline.code(frame))?;
    }
    Ok(writeln!(out, "            }}")?)
}
