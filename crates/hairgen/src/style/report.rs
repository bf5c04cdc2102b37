use super::surfaces::CrossedSurface;
use crate::fit::FitReport;
use crate::{DensityHistogram, HairReport};
use rapunzel_collision::field::Repairs;
use std::fmt;

/// Distance from which on a scalp is told to be off its head, m: more than its field is off.
const SEEN: f64 = 1e-3;

/// What became of a style.
#[derive(Debug, Clone, PartialEq)]
pub struct StyleReport {
    /// Area of the scalp, m^2.
    pub scalp_area: f64,
    /// Largest distance of the scalp from the head, m.
    pub scalp_off: f64,
    /// Part of the scalp's area that lies outside of the surface of the hair.
    pub bare: f64,
    /// Length that all hairs together should have, m.
    pub asked: f64,
    /// Number of pores.
    pub count: usize,
    /// How the hairs keep to the region.
    pub hairs: HairReport,
    /// Number of pre-guides.
    pub pre_guides: usize,
    /// How many of them found no place.
    pub pre_guides_without_place: usize,
    /// Number of guides that found a place.
    pub guides: usize,
    /// Numbers of the pores whose guides found none.
    pub guides_without_place: Vec<usize>,
    /// Number of equilibria of all guides.
    pub equilibria: usize,
    /// How evenly the guides fill the region.
    pub histogram: DensityHistogram,
    /// What the fit of the head to a scan found.
    pub fit: Option<FitReport>,
    /// What was mended of the surfaces.
    pub mended: Vec<(&'static str, Repairs)>,
    /// Surfaces of files that cut through themselves.
    pub crossed: Vec<CrossedSurface>,
}

impl fmt::Display for StyleReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (what, repairs) in &self.mended {
            writeln!(f, "  mended      {what}: {repairs}")?;
        }
        for surface in &self.crossed {
            writeln!(f, "  crossing    {surface}")?;
        }
        if let Some(fit) = &self.fit {
            writeln!(f, "  head        {fit}")?;
        }
        if self.scalp_off > SEEN {
            writeln!(f, "  scalp       up to {:.1} mm off the head", 1e3 * self.scalp_off)?;
        }
        if self.bare > 0.0 {
            let bare = 1e2 * self.bare;
            writeln!(f, "  bare        {bare:.1} % of the scalp is outside of the hair's surface")?;
        }
        let placed = self.count - self.hairs.without_place.len();
        writeln!(
            f,
            "  hairs       {placed} of {} on {:.0} cm^2, {:.0} per cm^2, {:.1} cm long on average, \
             of {:.1} asked for",
            self.count,
            1e4 * self.scalp_area,
            1e-4 * placed as f64 / self.scalp_area,
            1e2 * self.hairs.length / placed.max(1) as f64,
            1e2 * self.asked / self.count as f64,
        )?;
        writeln!(
            f,
            "  guides      {} of {} found a place, {:.1} equilibria each; {} of {} \
             pre-guides",
            self.guides,
            self.guides + self.guides_without_place.len(),
            self.equilibria as f64 / self.guides.max(1) as f64,
            self.pre_guides - self.pre_guides_without_place,
            self.pre_guides,
        )?;
        writeln!(f, "  in head     {} of {} segments", self.hairs.in_head, self.hairs.segments)?;
        writeln!(
            f,
            "  outside     {:.3} % of the length",
            1e2 * self.hairs.outside / self.hairs.length.max(f64::MIN_POSITIVE)
        )?;
        write!(f, "  evenness    Gini coefficient {:.3} of the guides", self.histogram.gini())
    }
}
