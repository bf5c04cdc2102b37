//! POV-Ray scene description: a `#declare` of all fibres and one of all objects.
//!
//! POV-Ray is left-handed with y up, and its tolerances are made for scenes of unit size: points
//! are written as `<x, z, y>`, which keeps what is right on the right, and in millimetres.

use super::surface::Placed;
use super::{ExportError, Frame};
use crate::framing::Framing;
use nalgebra::Point3;
use std::io::Write;

/// Millimetres per metre.
const SCALE: f64 = 1e3;

/// Writes `frame` as the object `Hair`, a cone per segment, which POV-Ray traces much faster than
/// one long sphere sweep; and `objects`, if there are any, as the mesh `Objects`. By itself the
/// file is a picture of both; for a scene of your own, `#declare Included = 1;` and `#include` it
/// before `object { Hair texture { ... } }`.
///
/// # Errors
/// Refuses invalid and empty frames, and surfaces that are not finite; fails if `out` does.
pub fn write(out: &mut impl Write, frame: &Frame, objects: &[Placed]) -> Result<(), ExportError> {
    let framing = Framing::of(frame, objects)?;
    let (fibers, count) = (frame.strands.len(), objects.len());
    writeln!(out, "#version 3.7;")?;
    writeln!(out, "// Frame {} at {} s, in millimetres, y up.", frame.index, frame.time)?;
    writeln!(out, "// Hair: {fibers} fibres. Objects: {count}.")?;
    writeln!(out, "#declare Hair = union {{")?;
    for strand in &frame.strands {
        for j in 0..strand.frames.len() {
            let [a, b] = [j, j + 1].map(|i| vector(&strand.points[i]));
            let [thick, thin] = [j, j + 1].map(|i| SCALE * strand.radii[i]);
            // POV-Ray stops at a cone without length.
            if a != b {
                writeln!(out, "  cone {{ {a}, {thick:.6}, {b}, {thin:.6} }}")?;
            }
        }
    }
    writeln!(out, "}}")?;
    if !objects.is_empty() {
        mesh(out, objects)?;
    }
    picture(out, &framing, !objects.is_empty())
}

/// A point in POV-Ray's notation and coordinates.
fn vector(p: &Point3<f64>) -> String {
    let [x, y, z] = p.coords.data.0[0].map(|x| SCALE * x);
    format!("<{x:.6}, {z:.6}, {y:.6}>")
}

/// Declares the objects, all as one mesh.
fn mesh(out: &mut impl Write, objects: &[Placed]) -> Result<(), ExportError> {
    let vertices: usize = objects.iter().map(|object| object.surface.vertices.len()).sum();
    let triangles: usize = objects.iter().map(|object| object.surface.triangles.len()).sum();
    write!(out, "#declare Objects = mesh2 {{\n  vertex_vectors {{ {vertices}")?;
    for p in objects.iter().flat_map(|object| &object.surface.vertices) {
        write!(out, ",\n    {}", vector(p))?;
    }
    write!(out, " }}\n  face_indices {{ {triangles}")?;
    let mut first = 0;
    for Placed { surface, .. } in objects {
        for corners in &surface.triangles {
            let [a, b, c] = corners.map(|corner| first + corner as usize);
            write!(out, ",\n    <{a}, {b}, {c}>")?;
        }
        first += surface.vertices.len();
    }
    Ok(writeln!(out, " }}\n}}")?)
}

/// Writes camera, light and objects, for a file that is not included in another.
fn picture(
    out: &mut impl Write,
    Framing { middle, eye, lamp, .. }: &Framing,
    has_objects: bool,
) -> Result<(), ExportError> {
    writeln!(out, "#ifndef (Included)\nglobal_settings {{ assumed_gamma 1 }}")?;
    writeln!(out, "camera {{ location {} look_at {} angle 40 }}", vector(eye), vector(middle))?;
    writeln!(out, "light_source {{ {} rgb 1 }}\nbackground {{ rgb 1 }}", vector(lamp))?;
    writeln!(out, "object {{\n  Hair pigment {{ rgb <0.30, 0.17, 0.09> }}")?;
    // Light that other fibres would scatter, and what they reflect.
    writeln!(out, "  finish {{ ambient 0.2 diffuse 0.8 specular 0.4 roughness 0.04 }}\n}}")?;
    if has_objects {
        writeln!(out, "object {{ Objects pigment {{ rgb <0.66, 0.71, 0.76> }} }}")?;
    }
    Ok(writeln!(out, "#end")?)
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    fn text(frame: &Frame, objects: &[Placed]) -> String {
        let mut out = Vec::new();
        write(&mut out, frame, objects).expect("memory");
        String::from_utf8(out).expect("text")
    }

    #[test]
    fn every_segment_is_a_cone_and_every_object_in_the_mesh() {
        let (frame, objects) = (sample::frame(2), sample::objects(0.1));
        let text = text(&frame, &objects);
        assert_eq!(text.matches("cone").count(), 5 + 8 + 11);
        assert_eq!(text.matches('{').count(), text.matches('}').count());
        let p = frame.strands[0].points[5];
        let line = format!("<{:.6}, 300.000000, {:.6}>", 1e3 * p.x, 1e3 * p.y);
        assert!(text.contains(&line), "{line} not in {text}");
        let [a, b] = [0, 1].map(|i| &objects[i].surface);
        let vertices = a.vertices.len() + b.vertices.len();
        assert!(text.contains(&format!("vertex_vectors {{ {vertices},\n")), "{text}");
        let last = b.triangles.last().expect("one").map(|v| v as usize + a.vertices.len());
        let last = format!("<{}, {}, {}> }}", last[0], last[1], last[2]);
        assert!(text.contains(&last), "{last} not in {text}");
        assert!(text.contains("// Hair: 3 fibres. Objects: 2."), "{text}");
    }

    #[test]
    fn a_segment_without_length_is_left_out() {
        let mut frame = sample::frame(0);
        frame.strands[0].points[3] = frame.strands[0].points[2];
        let text = text(&frame, &[]);
        assert_eq!(text.matches("cone").count(), 23);
        assert!(!text.contains("object { Objects"), "{text}");
    }

    #[test]
    fn no_fiber_is_no_object() {
        let frame = Frame { index: 0, time: 0.0, strands: vec![] };
        assert!(matches!(write(&mut Vec::new(), &frame, &[]), Err(ExportError::Empty)));
    }
}
