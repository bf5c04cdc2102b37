//! Numbers of a style that are wrong whatever its files hold.

use super::spec::{FlowSpec, HairSource, HeadSource, ScalpField, Style};
use crate::error::choice;
use crate::growth::{LENGTHS, MOST_DENSITY};
use crate::head::ParametricHead;
use crate::{DensityModel, HairgenError};
use std::ops::RangeInclusive;

/// Most hairs of a style.
const MOST_HAIRS: usize = 1_000_000;

impl Style {
    /// Checks the numbers of the style as far as they do not depend on its files, as
    /// [`Style::grow`] does before all else.
    ///
    /// # Errors
    /// [`HairgenError::Choice`], [`HairgenError::HairCount`], [`HairgenError::Measure`].
    pub fn check(&self) -> Result<(), HairgenError> {
        match &self.head {
            HeadSource::Parametric { measures, hairline } => {
                ParametricHead::new(*measures, hairline.clone())?;
            }
            HeadSource::Scan { options, .. } => options.validate()?,
            HeadSource::Mesh { .. } => {}
        }
        match &self.hair {
            HairSource::Volume(volume) => volume.validate()?,
            HairSource::Shell { thickness, .. } => {
                let thin = |x: f64| x > 0.0 && x <= 0.1;
                choice("the thickness of the hair's shell (m)", *thickness, "in (0, 0.1]", thin)?;
            }
            HairSource::Solid(_) | HairSource::Scan => {}
        }
        if let Some(count) = self.hairs {
            check_count(count)?;
        }
        let [shortest, longest] = LENGTHS;
        let density = "between 0 and 1e10";
        self.density.check("the density (hairs per m^2)", 0.0..=MOST_DENSITY, density)?;
        // Of an image the length counts where a pore is.
        let least = if let ScalpField::Constant(_) = self.length { shortest } else { 0.0 };
        self.length.check("the length of the hairs (m)", least..=longest, "0.0001 to 10")?;
        if let Some(tilt) = &self.tilt {
            tilt.check("the tilt (degrees)", 0.0..=90.0, "between 0 and 90")?;
        }
        match &self.flow {
            FlowSpec::Angle(angle) => {
                angle.check("the angle of growth (degrees)", f64::MIN..=f64::MAX, "finite")?;
            }
            FlowSpec::Whorl { turn, reach, .. } => {
                choice("the turn of the whorl (degrees)", *turn, "finite", |_| true)?;
                choice("the reach of the whorl (m)", *reach, "positive", |x| x > 0.0)?;
            }
        }
        let (pre, guides) = (self.pre_guides, self.guides as f64);
        let dense = |x: f64| x > 0.0 && x <= 1e6;
        choice("the number of pre-guides per m^2", pre, "positive, at most 1e6", dense)?;
        let few = |x: f64| (1.0..=1e5).contains(&x);
        choice("the number of guides", guides, "between 1 and 100000", few)?;
        for dip in self.dips {
            choice("a dip of the pre-guides", dip, "in [0, 1]", |x| (0.0..=1.0).contains(&x))?;
        }
        self.guide.options.validate()?;
        match self.guide.density {
            Some(DensityModel::Binary { radius }) => {
                let thin = |x: f64| x > 0.0 && x <= 0.1;
                choice("the radius of a wisp (m)", radius, "in (0, 0.1]", thin)?;
            }
            Some(DensityModel::Continuous { most }) => {
                choice("the largest density of guides", most, "positive", |x| x > 0.0)?;
            }
            None => {}
        }
        if let Some(trim) = self.trim {
            choice("the height of the trim (m)", trim, "between -2 and 1", |x| {
                (-2.0..=1.0).contains(&x)
            })?;
        }
        let side = |x: f64| (5e-4..=0.1).contains(&x);
        choice("the side of a voxel (m)", self.guide.voxel.0, "between 0.0005 and 0.1", side)?;
        self.strands.validate()
    }
}

impl ScalpField {
    /// Checks all the values that the field can have.
    fn check(
        &self,
        what: &'static str,
        allowed: RangeInclusive<f64>,
        range: &'static str,
    ) -> Result<(), HairgenError> {
        let ends = match self {
            Self::Constant(value) => [value, value],
            Self::Image { black, white, .. } => [black, white],
        };
        ends.into_iter().try_for_each(|end| choice(what, *end, range, |x| allowed.contains(&x)))
    }
}

/// Checks a number of hairs.
pub(super) fn check_count(count: usize) -> Result<(), HairgenError> {
    if count == 0 || count > MOST_HAIRS {
        return Err(HairgenError::HairCount { count, most: MOST_HAIRS });
    }
    Ok(())
}
