//! Fields on grids.

use crate::error::check_count;
use crate::{ElectrostaticsError, Fields};
use nalgebra::{Point3, Vector3};
use std::io::Write;

/// Lattice of points, x fastest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldGrid {
    /// Position of the first point (world), m.
    pub origin: Point3<f64>,
    /// Steps from point to point along each axis (world), m.
    pub spacing: Vector3<f64>,
    /// Numbers of points along each axis; one for a plane.
    pub counts: [usize; 3],
}

impl FieldGrid {
    /// Positions of all points (world, m), x fastest: the targets of a [`Method`](crate::Method).
    #[must_use]
    pub fn points(&self) -> Vec<Point3<f64>> {
        let [nx, ny, nz] = self.counts;
        let place = |i: usize, j: usize, k: usize| {
            let steps = Vector3::new(i as f64, j as f64, k as f64);
            self.origin + self.spacing.component_mul(&steps)
        };
        (0..nz)
            .flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| place(i, j, k))))
            .collect()
    }

    /// Writes the fields at the points as a VTK image (`.vti`), raw binary in double precision,
    /// with the point data `potential` (V) and `field` (V/m). 32 bytes a point.
    ///
    /// # Errors
    /// Fields that are not of as many points, and a writer that fails.
    pub fn write_vti(
        &self,
        out: &mut dyn Write,
        fields: &Fields,
    ) -> Result<(), ElectrostaticsError> {
        let count = self.counts.iter().product();
        check_count("potentials", fields.potentials.len(), count)?;
        check_count("fields", fields.fields.len(), count)?;
        self.write(out, fields).map_err(|error| ElectrostaticsError::Write(error.to_string()))
    }

    /// Writes the header, the potentials and the fields.
    fn write(&self, out: &mut dyn Write, fields: &Fields) -> std::io::Result<()> {
        let [i, j, k] = self.counts.map(|n| n.saturating_sub(1));
        let extent = format!("0 {i} 0 {j} 0 {k}");
        let ([x, y, z], [dx, dy, dz]): ([f64; 3], [f64; 3]) =
            (self.origin.into(), self.spacing.into());
        let second = 8 + 8 * fields.potentials.len();
        let array = |name: &str, more: &str, offset: usize| {
            let what = format!(r#"type="Float64" Name="{name}"{more}"#);
            format!(r#"<DataArray {what} format="appended" offset="{offset}"/>"#)
        };
        let potential = array("potential", "", 0);
        let field = array("field", r#" NumberOfComponents="3""#, second);
        write!(
            out,
            r#"<?xml version="1.0"?>
<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
  <ImageData WholeExtent="{extent}" Origin="{x} {y} {z}" Spacing="{dx} {dy} {dz}">
    <Piece Extent="{extent}">
      <PointData Scalars="potential" LaneVector="field">
        {potential}
        {field}
      </PointData>
    </Piece>
  </ImageData>
  <AppendedData encoding="raw">
_"#
        )?;
        let potentials: Vec<_> = fields.potentials.iter().flat_map(|v| v.to_le_bytes()).collect();
        let vectors: Vec<_> =
            fields.fields.iter().flat_map(|e| e.iter().flat_map(|x| x.to_le_bytes())).collect();
        for block in [potentials, vectors] {
            out.write_all(&(block.len() as u64).to_le_bytes())?;
            out.write_all(&block)?;
        }
        out.write_all(b"\n  </AppendedData>\n</VTKFile>\n")
    }
}
