use super::{END, POINT_DATA};
use crate::{ExportError, Frame, Strand};
use std::borrow::Borrow;
use std::io::{Seek, SeekFrom, Write};

/// Number of bytes of an array that are buffered and written together.
const WAITING: usize = 1 << 16;

/// Writes `frame`. Cost: about 220 bytes per point.
///
/// # Errors
/// Refuses invalid frames, when some of the file may be written; fails if `out` does.
pub fn write(out: &mut (impl Write + Seek), frame: &Frame) -> Result<(), ExportError> {
    let counts: Vec<usize> = frame.strands.iter().map(|strand| strand.points.len()).collect();
    write_strands(out, (frame.index, frame.time), &counts, frame.strands.iter())
}

/// Writes a frame of this index and time (s) whose strands come one by one; `counts` are the
/// numbers of their points. Cost: about 220 bytes per point, and the memory of one strand.
///
/// # Errors
/// Refuses invalid frames, when some of the file may be written; fails if `out` does.
pub fn write_strands<S: Borrow<Strand>>(
    out: &mut (impl Write + Seek),
    (index, time): (usize, f64),
    counts: &[usize],
    strands: impl Iterator<Item = S>,
) -> Result<(), ExportError> {
    let (points, lines) = (counts.iter().sum(), counts.len());
    header(out, (index, time), [points, lines])?;
    let mut at = out.stream_position()?;
    // A strand has some of all arrays, which lie one behind the other.
    let mut arrays = Vec::new();
    for parts in [3].into_iter().chain(POINT_DATA.map(|(_, parts)| parts)) {
        let size = 8 * (parts * points) as u64;
        arrays.push(DataArray { at, waiting: size.to_le_bytes().to_vec() });
        at += 8 + size;
    }
    for (i, (strand, &expected)) in strands.zip(counts).enumerate() {
        let strand = strand.borrow();
        strand.validate(i)?;
        let found = strand.points.len();
        if found != expected {
            return Err(ExportError::Count { strand: i, what: "points", found, expected });
        }
        let positions = strand.points.iter().flat_map(|p| p.coords.data.0[0]).collect();
        let data = POINT_DATA.iter().map(|(name, _)| point_data(strand, name));
        for (array, numbers) in arrays.iter_mut().zip([positions].into_iter().chain(data)) {
            array.waiting.extend(numbers.into_iter().flat_map(f64::to_le_bytes));
            if array.waiting.len() >= WAITING {
                array.write(out)?;
            }
        }
    }
    arrays.iter_mut().try_for_each(|array| array.write(out))?;
    out.seek(SeekFrom::Start(at))?;
    let ends = counts.iter().scan(0_u64, |end, &count| {
        *end += count as u64;
        Some(*end)
    });
    block(out, points, 0..points as u64)?;
    block(out, lines, ends)?;
    block(out, lines, 0..lines as u64)?;
    out.write_all(END)?;
    Ok(())
}

/// An array that is being written, with its buffer.
struct DataArray {
    /// Byte offset of the buffered bytes in the file.
    at: u64,
    waiting: Vec<u8>,
}

impl DataArray {
    /// Writes the buffered bytes.
    fn write(&mut self, out: &mut (impl Write + Seek)) -> Result<(), ExportError> {
        out.seek(SeekFrom::Start(self.at))?;
        out.write_all(&self.waiting)?;
        self.at += self.waiting.len() as u64;
        self.waiting.clear();
        Ok(())
    }
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
        "contact_force" => strand.contact_forces.iter().flat_map(|v| v.data.0[0]).collect(),
        "charge" => strand.charges.clone(),
        "force" => segments().flat_map(|j| strand.forces[j].data.0[0]).collect(),
        _ => {
            segments().map(|j| strand.frames[j].matrix().column(2).dot(&strand.forces[j])).collect()
        }
    }
}

fn header(
    out: &mut impl Write,
    (index, time): (usize, f64),
    [points, lines]: [usize; 2],
) -> Result<(), ExportError> {
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
pub(crate) trait Bytes {
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
pub(crate) fn block<T: Bytes>(
    out: &mut impl Write,
    count: usize,
    mut numbers: impl Iterator<Item = T>,
) -> Result<(), ExportError> {
    out.write_all(&(8 * count as u64).to_le_bytes())?;
    numbers.try_for_each(|number| out.write_all(&number.bytes()))?;
    Ok(())
}
