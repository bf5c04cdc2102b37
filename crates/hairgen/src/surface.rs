use crate::HairgenError;
use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::{
    DistanceField, Grid, GridFrame, Mesh, MeshDistance, Repairs, Sample, Shell, Soup,
};

/// How finely the distance of a surface is stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldResolution {
    /// Spacing of the fine grid near the surface, m.
    pub spacing: f64,
    /// Distance up to which the fine grid reaches, m; at least two spacings.
    pub band: f64,
    /// Spacing of the coarse grid beyond, m.
    pub coarse_spacing: f64,
    /// Distance up to which the coarse grid reaches, m; beyond, values are clipped inside.
    pub coarse_band: f64,
}

impl Default for FieldResolution {
    /// 1 mm up to 4 mm, and 8 mm up to 32 mm.
    fn default() -> Self {
        Self { spacing: 1e-3, band: 4e-3, coarse_spacing: 8e-3, coarse_band: 32e-3 }
    }
}

/// The distance of a surface near and far: a fine sparse grid about the surface, a coarse one
/// beyond, and a smooth transition between the two.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceField {
    fine: Grid,
    coarse: Grid,
}

/// Part of the fine grid's band from which on the coarse grid has a weight.
const TRANSITION: f64 = 0.5;

impl SurfaceField {
    /// The signed distance of a solid. Cost: the scan of its faces, edges and vertices into the
    /// fine grid, and a search through a hierarchy for every node of the coarse one.
    ///
    /// # Errors
    /// [`HairgenError::Surface`] where a grid cannot be made.
    pub fn solid(
        what: &'static str,
        mesh: &Mesh,
        resolution: FieldResolution,
    ) -> Result<Self, HairgenError> {
        let surface = |source| HairgenError::Surface { what, source };
        let fine = Grid::scan(mesh, resolution.spacing, resolution.band).map_err(surface)?;
        let [low, high] = mesh.bounds();
        let exact = MeshDistance::new(mesh);
        Ok(Self { fine, coarse: coarse(what, &exact, [low, high], resolution)? })
    }

    /// The signed distance of a solid that a file describes with faults, and what was mended.
    ///
    /// # Errors
    /// [`HairgenError::Surface`] of what cannot be mended.
    pub fn mended(
        what: &'static str,
        soup: Soup,
        resolution: FieldResolution,
    ) -> Result<(Self, Repairs), HairgenError> {
        let surface = |source| HairgenError::Surface { what, source };
        let (mesh, repairs) = Mesh::repaired(soup).map_err(surface)?;
        Ok((Self::solid(what, &mesh, resolution)?, repairs))
    }

    /// The distance of a surface that need not be closed or connected, as a shell of `thickness`, m
    /// (thesis 5.3): positive on both sides, negative within the shell.
    ///
    /// # Errors
    /// [`HairgenError::Surface`] where a grid cannot be made or the surface is none.
    pub fn shell(
        what: &'static str,
        soup: &Soup,
        thickness: f64,
        resolution: FieldResolution,
    ) -> Result<Self, HairgenError> {
        let surface = |source| HairgenError::Surface { what, source };
        let shell = Shell::new(soup, thickness).map_err(surface)?;
        // The distance has a kink at the surface: no cell of the coarse grid that counts may
        // reach there.
        let resolution = FieldResolution {
            coarse_spacing: 0.5 * resolution.coarse_spacing,
            band: resolution.band.max(2.0 * resolution.coarse_spacing),
            ..resolution
        };
        let bounds = bounds(soup);
        let margin = Vector3::repeat(resolution.band + 0.5 * thickness + resolution.spacing);
        let frame = GridFrame::new(bounds[0] - margin, bounds[1] + margin, resolution.spacing);
        let fine = frame.and_then(|frame| Grid::sample(&shell, frame, resolution.band));
        Ok(Self { fine: fine.map_err(surface)?, coarse: coarse(what, &shell, bounds, resolution)? })
    }
}

/// Low and high corner of the smallest box that holds the triangles (world), m.
pub(crate) fn bounds(soup: &Soup) -> [Point3<f64>; 2] {
    let far = Vector3::repeat(f64::INFINITY);
    let corners =
        soup.triangles.as_flattened().iter().filter_map(|&v| soup.vertices.get(v as usize));
    let (low, high) =
        corners.fold((far, -far), |(low, high), p| (low.inf(&p.coords), high.sup(&p.coords)));
    [low.into(), high.into()]
}

/// The coarse grid of a field about a surface that lies between two corners of a box.
fn coarse(
    what: &'static str,
    field: &impl DistanceField,
    [low, high]: [Point3<f64>; 2],
    resolution: FieldResolution,
) -> Result<Grid, HairgenError> {
    let (spacing, band) = (resolution.coarse_spacing, resolution.coarse_band);
    let margin = Vector3::repeat(band + spacing);
    let frame = GridFrame::new(low - margin, high + margin, spacing);
    let grid = frame.and_then(|frame| Grid::sample(field, frame, band));
    grid.map_err(|source| HairgenError::Surface { what, source })
}

impl DistanceField for SurfaceField {
    fn sample(&self, point: &Point3<f64>) -> Sample {
        let fine = self.fine.sample(point);
        let (from, to) = (TRANSITION * self.fine.band(), self.fine.band());
        let size = fine.value.abs();
        if size <= from {
            return fine;
        }
        let coarse = self.coarse.sample(point);
        if size >= to {
            return coarse;
        }
        // The weight of the coarse grid rises from 0 to 1 with no kink at either end.
        let x = (size - from) / (to - from);
        let weight = x * x * (3.0 - 2.0 * x);
        let slope = 6.0 * x * (1.0 - x) / (to - from) * fine.value.signum();
        let difference = coarse.value - fine.value;
        Sample {
            value: fine.value + weight * difference,
            gradient: fine.gradient * (1.0 - weight + slope * difference)
                + coarse.gradient * weight,
        }
    }

    fn lipschitz(&self) -> f64 {
        let transition = (1.0 - TRANSITION) * self.fine.band();
        let apart = self.fine.error() + self.coarse.error();
        self.fine.lipschitz().max(self.coarse.lipschitz()) + 1.5 * apart / transition
    }

    fn error(&self) -> f64 {
        self.fine.error().max(self.coarse.error())
    }

    fn band(&self) -> f64 {
        self.coarse.band()
    }
}
