//! Wavefront OBJ: the points of all strands (m), and a line for each strand; or the triangles of
//! objects. It holds no radii.

use super::surface::{self, Placed};
use super::{ExportError, Frame};
use crate::text::single;
use nalgebra::Point3;
use std::io::Write;

/// Writes the strands of `frame` as lines, with the fewest digits that read back the same in single
/// precision.
///
/// # Errors
/// Refuses invalid frames and numbers beyond single precision; fails if `out` does.
pub fn write(out: &mut impl Write, frame: &Frame) -> Result<(), ExportError> {
    frame.validate()?;
    writeln!(out, "# Rapunzel, frame {} at {} s, in meters", frame.index, frame.time)?;
    points(out, frame.strands.iter().flat_map(|strand| &strand.points))?;
    // Points are numbered from one.
    let mut first = 1;
    for strand in &frame.strands {
        out.write_all(b"l")?;
        for number in first..first + strand.points.len() {
            write!(out, " {number}")?;
        }
        out.write_all(b"\n")?;
        first += strand.points.len();
    }
    Ok(())
}

/// Writes the triangles of `objects` where they are (world, m), each object as a group.
///
/// # Errors
/// Refuses surfaces that are not finite and numbers beyond single precision; fails if `out` does.
pub fn write_objects(out: &mut impl Write, objects: &[Placed]) -> Result<(), ExportError> {
    // Points are numbered from one.
    let mut first = 1;
    for (i, Placed { surface, .. }) in objects.iter().enumerate() {
        surface::check(surface)?;
        writeln!(out, "g object_{i}")?;
        points(out, &surface.vertices)?;
        for corners in &surface.triangles {
            let [a, b, c] = corners.map(|corner| first + corner as usize);
            writeln!(out, "f {a} {b} {c}")?;
        }
        first += surface.vertices.len();
    }
    Ok(())
}

fn points<'a>(
    out: &mut impl Write,
    points: impl IntoIterator<Item = &'a Point3<f64>>,
) -> Result<(), ExportError> {
    for point in points {
        out.write_all(b"v")?;
        for x in &point.coords {
            out.write_all(b" ")?;
            single(out, *x)?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    #[test]
    fn every_strand_is_a_line_over_its_own_points() {
        let frame = sample::frame(1);
        let mut bytes = Vec::new();
        write(&mut bytes, &frame).expect("memory");
        let text = String::from_utf8(bytes).expect("text");
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines.len(), 1 + 27 + 3);
        assert_eq!(lines[28], "l 1 2 3 4 5 6");
        assert_eq!(lines[29], "l 7 8 9 10 11 12 13 14 15");
        let numbers: Vec<f32> =
            lines[6].split(' ').skip(1).map(|x| x.parse().expect("a number")).collect();
        let point = frame.strands[0].points[5];
        for (axis, x) in numbers.into_iter().enumerate() {
            assert!((f64::from(x) - point[axis]).abs() < 2e-8);
        }
    }

    #[test]
    fn every_triangle_has_the_corners_of_its_object() {
        let objects = sample::objects(0.1);
        let mut bytes = Vec::new();
        write_objects(&mut bytes, &objects).expect("memory");
        let text = String::from_utf8(bytes).expect("text");
        let count = |start: &str| text.lines().filter(|line| line.starts_with(start)).count();
        let [a, b] = [0, 1].map(|i| &objects[i].surface);
        let vertices = a.vertices.len();
        assert_eq!((count("g "), count("v ")), (2, vertices + b.vertices.len()));
        assert_eq!(count("f "), a.triangles.len() + b.triangles.len());
        let last = b.triangles.last().expect("one").map(|v| 1 + vertices + v as usize);
        assert!(text.ends_with(&format!("f {} {} {}\n", last[0], last[1], last[2])), "{text}");
        let mut broken = objects;
        broken[1].surface.triangles[0] = [0, 1, 1_000_000];
        let written = write_objects(&mut Vec::new(), &broken);
        assert!(matches!(written, Err(ExportError::Surface { .. })));
    }
}
