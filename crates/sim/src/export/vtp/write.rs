use super::{END, POINT_DATA};
use crate::export::{ExportError, Frame, Strand};
use std::io::Write;

/// Writes `frame`. Cost: about 190 bytes per point.
///
/// # Errors
/// Refuses unsound frames; fails if `out` does.
pub fn write(out: &mut impl Write, frame: &Frame) -> Result<(), ExportError> {
    frame.validate()?;
    header(out, frame)?;
    let strands = || frame.strands.iter();
    let (points, lines) = (frame.points(), frame.strands.len());
    let positions = strands().flat_map(|s| &s.points).flat_map(|p| p.coords.iter().copied());
    block(out, 3 * points, positions)?;
    for (name, parts) in POINT_DATA {
        block(out, parts * points, strands().flat_map(|strand| point_data(strand, name)))?;
    }
    let ends = strands().scan(0_u64, |end, strand| {
        *end += strand.points.len() as u64;
        Some(*end)
    });
    block(out, points, 0..points as u64)?;
    block(out, lines, ends)?;
    block(out, lines, 0..lines as u64)?;
    out.write_all(END)?;
    Ok(())
}

/// The numbers of one strand for the array `name` of [`POINT_DATA`].
fn point_data(strand: &Strand, name: &str) -> Vec<f64> {
    let last = strand.frames.len() - 1;
    let segments = || (0..=last).chain([last]);
    let director = |k: usize| {
        segments()
            .flat_map(|j| strand.frames[j].matrix().column(k).into_owned().data.0[0])
            .collect()
    };
    match name {
        "radius" => strand.radii.clone(),
        "velocity" => strand.velocities.iter().flat_map(|v| v.data.0[0]).collect(),
        "curvature" => strand.curvatures.iter().flat_map(|v| v.data.0[0]).collect(),
        "d1" => director(0),
        "d2" => director(1),
        "d3" => director(2),
        "force" => segments().flat_map(|j| strand.forces[j].data.0[0]).collect(),
        _ => {
            segments().map(|j| strand.frames[j].matrix().column(2).dot(&strand.forces[j])).collect()
        }
    }
}

fn header(out: &mut impl Write, frame: &Frame) -> Result<(), ExportError> {
    let (points, lines) = (frame.points(), frame.strands.len());
    let (time, index) = (frame.time, frame.index);
    write!(
        out,
        r#"<?xml version="1.0"?>
<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
  <PolyData>
    <FieldData>
      <DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">{time}</DataArray>
      <DataArray type="Int64" Name="FrameIndex" NumberOfTuples="1" format="ascii">{index}</DataArray>
    </FieldData>
    <Piece NumberOfPoints="{points}" NumberOfVerts="0" NumberOfLines="{lines}" NumberOfStrips="0" NumberOfPolys="0">
"#
    )?;
    let mut offset = 0;
    let mut array = |out: &mut dyn Write, kind: &str, name: &str, parts: usize, count: usize| {
        let at = offset;
        offset += 8 + 8 * parts * count;
        writeln!(
            out,
            r#"        <DataArray type="{kind}" Name="{name}" NumberOfComponents="{parts}" format="appended" offset="{at}"/>"#
        )
    };
    writeln!(out, "      <Points>")?;
    array(out, "Float64", "Points", 3, points)?;
    writeln!(out, "      </Points>")?;
    writeln!(out, r#"      <PointData Scalars="radius" Vectors="velocity">"#)?;
    for (name, parts) in POINT_DATA {
        array(out, "Float64", name, parts, points)?;
    }
    writeln!(out, "      </PointData>")?;
    writeln!(out, "      <Lines>")?;
    array(out, "Int64", "connectivity", 1, points)?;
    array(out, "Int64", "offsets", 1, lines)?;
    writeln!(out, "      </Lines>")?;
    writeln!(out, r#"      <CellData Scalars="fiber">"#)?;
    array(out, "Int64", "fiber", 1, lines)?;
    writeln!(out, "      </CellData>")?;
    write!(out, "    </Piece>\n  </PolyData>\n  <AppendedData encoding=\"raw\">\n_")?;
    Ok(())
}

/// A number of eight bytes.
pub(in crate::export) trait Bytes {
    fn bytes(self) -> [u8; 8];
}

impl Bytes for f64 {
    fn bytes(self) -> [u8; 8] {
        self.to_le_bytes()
    }
}

impl Bytes for u64 {
    fn bytes(self) -> [u8; 8] {
        self.to_le_bytes()
    }
}

/// One array of the appended data: its size in bytes, then its `count` numbers.
pub(in crate::export) fn block<T: Bytes>(
    out: &mut impl Write,
    count: usize,
    mut numbers: impl Iterator<Item = T>,
) -> Result<(), ExportError> {
    out.write_all(&(8 * count as u64).to_le_bytes())?;
    numbers.try_for_each(|number| out.write_all(&number.bytes()))?;
    Ok(())
}
