use super::{Placed, check};
use crate::ExportError;
use crate::vtp::{
    END,
    read::{block as read_block, ended, field, header, number},
    write::block,
};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};
use rapunzel_collision::field::Soup;
use std::io::{BufRead, Write};

/// Number of scalars of a pose: its translation, and its rotation as the quaternion `i j k w`.
const POSE: usize = 7;

/// Writes all objects at a time, s: their triangles, with the number of the object as cell data
/// `object`; as field data the `Pose` of each, seven numbers: the position of the origin of its own
/// frame, and the quaternion `i j k w` of its rotation; and the `Counts` of its vertices and
/// triangles. Raw binary, double precision; about 100 bytes per vertex.
///
/// # Errors
/// Refuses surfaces that are not finite; fails if `out` does.
pub fn write(out: &mut impl Write, time: f64, objects: &[Placed]) -> Result<(), ExportError> {
    let surfaces: Vec<_> = objects.iter().map(|object| &object.surface).collect();
    surfaces.iter().try_for_each(|surface| check(surface))?;
    let count = objects.len();
    let points: usize = surfaces.iter().map(|surface| surface.vertices.len()).sum();
    let triangles: usize = surfaces.iter().map(|surface| surface.triangles.len()).sum();
    let sizes = [POSE * count, 2 * count, 3 * points, 3 * triangles, triangles];
    let mut end = 0;
    let [counts, places, corners, ends, of_triangles] = sizes.map(|size| {
        end += 8 * size + 8;
        end
    });
    write!(
        out,
        r#"<?xml version="1.0"?>
<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
  <PolyData>
    <FieldData>
      <DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">{time}</DataArray>
      <DataArray type="Float64" Name="Pose" NumberOfComponents="{POSE}" NumberOfTuples="{count}" format="appended" offset="0"/>
      <DataArray type="Int64" Name="Counts" NumberOfComponents="2" NumberOfTuples="{count}" format="appended" offset="{counts}"/>
    </FieldData>
    <Piece NumberOfPoints="{points}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="{triangles}">
      <Points>
        <DataArray type="Float64" Name="Points" NumberOfComponents="3" format="appended" offset="{places}"/>
      </Points>
      <Polys>
        <DataArray type="Int64" Name="connectivity" NumberOfComponents="1" format="appended" offset="{corners}"/>
        <DataArray type="Int64" Name="offsets" NumberOfComponents="1" format="appended" offset="{ends}"/>
      </Polys>
      <CellData Scalars="object">
        <DataArray type="Int64" Name="object" NumberOfComponents="1" format="appended" offset="{of_triangles}"/>
      </CellData>
    </Piece>
  </PolyData>
  <AppendedData encoding="raw">
_"#
    )?;
    let poses = objects.iter().flat_map(|Placed { pose, .. }| {
        pose.translation.vector.iter().chain(pose.rotation.coords.iter()).copied()
    });
    block(out, POSE * count, poses)?;
    let counts = surfaces.iter().flat_map(|s| [s.vertices.len() as u64, s.triangles.len() as u64]);
    block(out, 2 * count, counts)?;
    let vertices = surfaces.iter().flat_map(|s| &s.vertices);
    block(out, 3 * points, vertices.flat_map(|p| p.coords.data.0[0]))?;
    let starts = surfaces.iter().scan(0, |start, surface| {
        *start += surface.vertices.len() as u64;
        Some(*start - surface.vertices.len() as u64)
    });
    let corners = surfaces.iter().zip(starts).flat_map(|(surface, start)| {
        surface.triangles.iter().flatten().map(move |&v| start + u64::from(v))
    });
    block(out, 3 * triangles, corners)?;
    block(out, triangles, (1..=triangles as u64).map(|k| 3 * k))?;
    let numbered = (0_u64..).zip(&surfaces);
    let of_triangles = numbered.flat_map(|(k, surface)| surface.triangles.iter().map(move |_| k));
    block(out, triangles, of_triangles)?;
    out.write_all(END)?;
    Ok(())
}

/// Reads a file that [`write()`] wrote.
///
/// # Errors
/// [`ExportError::Malformed`] or [`ExportError::Io`] for anything else, also where it is cut short.
pub fn read(input: &mut impl BufRead) -> Result<Vec<Placed>, ExportError> {
    let header = header(input)?;
    let count: usize = number(field(&header, "Name=\"Pose\"", "NumberOfTuples=\"", "\"")?)?;
    let points: usize = number(field(&header, "<Piece", "NumberOfPoints=\"", "\"")?)?;
    let triangles: usize = number(field(&header, "<Piece", "NumberOfPolys=\"", "\"")?)?;
    let poses = poses(input, count)?;
    let counts = read_block(input, 2, count)?;
    let vertices = read_block(input, 3, points)?;
    let corners = read_block(input, 3, triangles)?;
    for _ in 0..2 {
        read_block(input, 1, triangles)?;
    }
    ended(input)?;
    let malformed = || ExportError::Malformed { what: "its objects are not one behind the other" };
    let index = |n: [u8; 8]| usize::try_from(u64::from_le_bytes(n)).map_err(|_| malformed());
    let (mut vertices, mut corners) = (vertices.as_chunks::<3>().0, corners.as_chunks::<3>().0);
    let mut first = 0;
    let mut objects = Vec::new();
    for (pose, &[count, triangles]) in poses.into_iter().zip(counts.as_chunks().0) {
        let own = vertices.split_off(..index(count)?).ok_or_else(malformed)?;
        let triangles = corners.split_off(..index(triangles)?).ok_or_else(malformed)?;
        let corner = |v: [u8; 8]| {
            let own = index(v)?.checked_sub(first).and_then(|v| u32::try_from(v).ok());
            own.ok_or_else(malformed)
        };
        let triangle = |&[a, b, c]: &[[u8; 8]; 3]| Ok([corner(a)?, corner(b)?, corner(c)?]);
        let surface = Soup {
            vertices: own.iter().map(|p| Point3::from(p.map(f64::from_le_bytes))).collect(),
            triangles: triangles.iter().map(triangle).collect::<Result<_, ExportError>>()?,
        };
        check(&surface)?;
        first += own.len();
        objects.push(Placed { pose, surface });
    }
    if !vertices.is_empty() || !corners.is_empty() {
        return Err(malformed());
    }
    Ok(objects)
}

/// Reads only the poses of the objects in a file that [`write()`] wrote.
///
/// # Errors
/// [`ExportError::Malformed`] or [`ExportError::Io`], as [`read()`].
pub fn read_poses(input: &mut impl BufRead) -> Result<Vec<Isometry3<f64>>, ExportError> {
    let header = header(input)?;
    let count = number(field(&header, "Name=\"Pose\"", "NumberOfTuples=\"", "\"")?)?;
    poses(input, count)
}

fn poses(input: &mut impl BufRead, count: usize) -> Result<Vec<Isometry3<f64>>, ExportError> {
    let numbers = read_block(input, POSE, count)?;
    let pose = |numbers: &[[u8; 8]; POSE]| {
        let [x, y, z, i, j, k, w] = numbers.map(f64::from_le_bytes);
        let rotation = Quaternion::new(w, i, j, k);
        let sound = [x, y, z].iter().all(|x| x.is_finite()) && (rotation.norm() - 1.0).abs() < 1e-6;
        sound
            .then(|| {
                let rotation = UnitQuaternion::new_unchecked(rotation);
                Isometry3::from_parts(Translation3::new(x, y, z), rotation)
            })
            .ok_or(ExportError::Malformed { what: "a pose is none" })
    };
    numbers.as_chunks().0.iter().map(pose).collect()
}
