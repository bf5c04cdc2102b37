use super::check;
use crate::export::ExportError;
use crate::export::vtp::{
    END,
    read::{block as read_block, ended, field, header, number},
    write::block,
};
use nalgebra::Point3;
use rapunzel_collision::field::Soup;
use std::io::{BufRead, Write};

/// Writes the surfaces of all objects at a time, s: triangles, with the number of their object as
/// cell data `object`, raw binary, double precision. About 100 bytes per vertex.
///
/// # Errors
/// Refuses surfaces that are not finite; fails if `out` does.
pub fn write(out: &mut impl Write, time: f64, surfaces: &[Soup]) -> Result<(), ExportError> {
    surfaces.iter().try_for_each(check)?;
    let points: usize = surfaces.iter().map(|surface| surface.vertices.len()).sum();
    let triangles: usize = surfaces.iter().map(|surface| surface.triangles.len()).sum();
    let [corners, ends, objects] =
        [24 * points + 8, 24 * (points + triangles) + 16, 24 * points + 32 * triangles + 24];
    write!(
        out,
        r#"<?xml version="1.0"?>
<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
  <PolyData>
    <FieldData>
      <DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">{time}</DataArray>
    </FieldData>
    <Piece NumberOfPoints="{points}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="{triangles}">
      <Points>
        <DataArray type="Float64" Name="Points" NumberOfComponents="3" format="appended" offset="0"/>
      </Points>
      <Polys>
        <DataArray type="Int64" Name="connectivity" NumberOfComponents="1" format="appended" offset="{corners}"/>
        <DataArray type="Int64" Name="offsets" NumberOfComponents="1" format="appended" offset="{ends}"/>
      </Polys>
      <CellData Scalars="object">
        <DataArray type="Int64" Name="object" NumberOfComponents="1" format="appended" offset="{objects}"/>
      </CellData>
    </Piece>
  </PolyData>
  <AppendedData encoding="raw">
_"#
    )?;
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
    let objects = (0_u64..).zip(surfaces);
    let of_triangles = objects.flat_map(|(k, surface)| surface.triangles.iter().map(move |_| k));
    block(out, triangles, of_triangles)?;
    out.write_all(END)?;
    Ok(())
}

/// Reads what [`write()`] wrote, all surfaces as one.
///
/// # Errors
/// [`ExportError::Malformed`] or [`ExportError::Io`] for anything else, also where it is cut short.
pub fn read(input: &mut impl BufRead) -> Result<Soup, ExportError> {
    let header = header(input)?;
    let points: usize = number(field(&header, "<Piece", "NumberOfPoints=\"", "\"")?)?;
    let triangles: usize = number(field(&header, "<Piece", "NumberOfPolys=\"", "\"")?)?;
    let vertices = read_block(input, 3, points)?;
    let corners = read_block(input, 3, triangles)?;
    for _ in 0..2 {
        read_block(input, 1, triangles)?;
    }
    ended(input)?;
    let vertices =
        vertices.as_chunks::<3>().0.iter().map(|p| Point3::from(p.map(f64::from_le_bytes)));
    let corner = |v: [u8; 8]| u32::try_from(u64::from_le_bytes(v)).unwrap_or(u32::MAX);
    let triangles = corners.as_chunks::<3>().0.iter().map(|t| t.map(corner));
    let surface = Soup { vertices: vertices.collect(), triangles: triangles.collect() };
    check(&surface).map(|()| surface)
}
