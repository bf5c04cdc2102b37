use super::similarity::Similarity;
use crate::HairgenError;
use crate::error::choice;
use crate::head::{Hairline, ParametricHead};
use rapunzel_collision::field::{Mesh, Soup};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A bald head that is fitted to scans: y up, the face along z, the origin within the head between
/// the ears, meters.
#[derive(Debug, Clone, PartialEq)]
pub struct HeadTemplate {
    /// Its closed surface, seen whole from the origin but for what is small.
    pub mesh: Soup,
    /// The rim of its scalp.
    pub hairline: Hairline,
}

impl From<&ParametricHead> for HeadTemplate {
    fn from(head: &ParametricHead) -> Self {
        Self { mesh: head.mesh(), hairline: head.hairline().clone() }
    }
}

/// How a head is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FitOptions {
    /// Meters for a unit of the scan; found from its size where it is left out.
    pub meters_per_unit: Option<f64>,
    /// Least depth of the skull under the surface of the hair, m, away from the hairline.
    pub margin: f64,
    /// Depth of hair from which on the surface counts as hair, m.
    pub threshold: f64,
    /// Whether hair hangs below the chin.
    pub hanging: bool,
    /// Sectors of the scalp's triangles about its middle.
    pub sectors: u32,
    /// Rings of the scalp's triangles.
    pub rings: u32,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            meters_per_unit: None,
            margin: 5e-3,
            threshold: 2e-3,
            hanging: false,
            sectors: 120,
            rings: 40,
        }
    }
}

impl FitOptions {
    pub(crate) fn validate(&self) -> Result<(), HairgenError> {
        let positive = |x: f64| x > 0.0;
        if let Some(unit) = self.meters_per_unit {
            choice("the meters per unit of the scan", unit, "positive", positive)?;
        }
        let depth = |x: f64| (0.0..=0.1).contains(&x);
        choice("the margin of the skull (m)", self.margin, "between 0 and 0.1", depth)?;
        choice("the threshold of hair (m)", self.threshold, "between 0 and 0.1", depth)?;
        let (sectors, rings) = (f64::from(self.sectors), f64::from(self.rings));
        let around = |x: f64| (3.0..=2e3).contains(&x);
        choice("the number of sectors of the scalp", sectors, "between 3 and 2000", around)?;
        let out = |x: f64| (1.0..=1e3).contains(&x);
        choice("the number of rings of the scalp", rings, "between 1 and 1000", out)
    }
}

/// How well a head was fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct FitReport {
    /// Meters for a unit of the scan.
    pub meters_per_unit: f64,
    /// From the template to the scan, in meters.
    pub similarity: Similarity,
    /// Root mean square of the distances of the face after the similarity, m: of the nearest three
    /// quarters.
    pub rms: f64,
    /// Root mean square of the distances of the face after the smooth deformation, m.
    pub deformed_rms: f64,
    /// Largest way of a vertex in the deformation, m.
    pub deformation: f64,
    /// Least and largest depth of the scalp under the surface of the hair, m.
    pub depth: [f64; 2],
}

impl fmt::Display for FitReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "a unit is {} m; head scaled by {:.3}; face off by {:.1} mm, then {:.1} mm; head bent by \
             up to {:.1} mm; hair {:.1} to {:.1} mm deep",
            self.meters_per_unit,
            self.similarity.scale,
            1e3 * self.rms,
            1e3 * self.deformed_rms,
            1e3 * self.deformation,
            1e3 * self.depth[0],
            1e3 * self.depth[1],
        )
    }
}

/// A scan taken apart, in meters, in the frame of the scan.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedHead {
    /// The scan in meters: the surface of head and hair together.
    pub hull: Mesh,
    /// The closed surface of the bald head.
    pub head: Soup,
    /// The part of the head where hair grows: a disc of triangles.
    pub scalp: Soup,
    /// The part of the scan that is hair.
    pub hair_surface: Soup,
    /// What was found.
    pub report: FitReport,
}
