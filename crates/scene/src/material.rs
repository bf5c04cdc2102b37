use super::check::{Allowed, Check};
use super::load::Profile;
use rapunzel_fiber::{self as fiber, NodeProperties, Section};
use rapunzel_keratin::law::{MaxwellElement, Relaxation, ThreeElement, Viscoelastic};
use rapunzel_keratin::{
    self as keratin, Hair, HairType, KeratinError, Outside, Thickness, Treatment,
};
use rapunzel_rod_dynamic::SectionLaws;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Material of a fibre.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum MaterialSpec {
    /// Dry human hair: 1300 kg/m^3, 3.8 GPa, a third of it in shear.
    #[default]
    Hair,
    /// A homogeneous, linearly elastic material.
    Elastic {
        /// Mass density, kg/m^3.
        density: f64,
        /// Young's modulus, Pa.
        youngs_modulus: f64,
        /// Shear modulus, Pa.
        shear_modulus: f64,
    },
    /// Measured properties, as of a cable, a hose or a yarn, whose stiffness is not that of a solid
    /// section; the section of the fibre is that of contacts, air and pictures.
    Measured {
        /// Bending stiffnesses about d1 and d2, N m^2.
        bending: [f64; 2],
        /// Torsion stiffness, N m^2.
        torsion: f64,
        /// Mass per length, kg/m.
        linear_density: f64,
        /// Rotary inertias per length about d1 and d2, kg m; that about the tangent is their sum.
        /// Left out, they are those of a homogeneous section.
        #[serde(default)]
        rotary_inertia: Option<[f64; 2]>,
    },
    /// Hair by the tables of `rapunzel-keratin`, in the climate of the environment: moduli,
    /// density, and the section where the bundle gives none.
    Keratin {
        /// Type of hair, whose diameters are used if the bundle gives no section.
        #[serde(rename = "type")]
        kind: HairType,
        /// Treatment of the hair.
        #[serde(default = "no_treatment")]
        treatment: Treatment,
        /// Class of diameters that Young's modulus is for.
        #[serde(default = "any_thickness")]
        thickness: Thickness,
        /// Constitutive law of the sections.
        #[serde(default)]
        law: Law,
        /// Whether values may be extrapolated beyond the measurements.
        #[serde(default)]
        extrapolate: bool,
    },
}

fn no_treatment() -> Treatment {
    Treatment::None
}

fn any_thickness() -> Thickness {
    Thickness::Any
}

/// Human hair by type and treatment, as in [`MaterialSpec::Keratin`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Keratin {
    /// Type of hair.
    pub kind: HairType,
    /// Treatment of the hair.
    pub treatment: Treatment,
    /// Class of diameters that Young's modulus is for.
    pub thickness: Thickness,
    /// Constitutive law of the sections.
    pub law: Law,
    /// Whether values may be extrapolated beyond the measurements.
    pub extrapolate: bool,
}

/// Constitutive law of a section of hair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Law {
    /// Hooke's law, with the moduli of the climate.
    #[default]
    Elastic,
    /// Moduli that relax as a power of time, so that free oscillations between 0.01 and 100 rad/s
    /// have the logarithmic decrement of table 2.10 at any frequency; at 1 rad/s the moduli are
    /// those of the climate.
    Viscoelastic,
    /// Nagase's model (`rapunzel_keratin::law::ThreeElement`), which follows the climate: the one
    /// that keeps a water wave.
    ThreeElement,
}

/// Humidity and temperature of the air over time. The water in hair is in equilibrium with the air
/// at once.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ClimateHistory {
    /// Relative humidity over time, straight lines between pairs of time (s) and fraction; constant
    /// before the first and after the last. 1 is wet.
    pub humidity: Vec<(f64, f64)>,
    /// Temperature, degrees Celsius.
    pub temperature: f64,
}

impl Default for ClimateHistory {
    fn default() -> Self {
        let keratin::Climate { humidity, temperature, .. } = keratin::Climate::STANDARD;
        Self { humidity: vec![(0.0, humidity.fraction())], temperature: temperature.celsius() }
    }
}

impl ClimateHistory {
    /// Climate at time `t`, s.
    ///
    /// # Errors
    /// [`KeratinError`] for a humidity or a temperature out of its range.
    pub fn at(&self, t: f64) -> Result<keratin::Climate, KeratinError> {
        let humidity = Profile::Linear { points: self.humidity.clone() }.at(t);
        keratin::Climate::new(humidity, self.temperature)
    }

    /// Whether the climate changes in time.
    #[must_use]
    pub fn changes(&self) -> bool {
        self.humidity.windows(2).any(|pair| pair[0].1 != pair[1].1)
    }

    pub(super) fn check(&self, check: &mut Check) {
        let course = Profile::Linear { points: self.humidity.clone() };
        if self.humidity.is_empty() {
            check.refuse("humidity", "is empty, but must have at least one entry".into());
        } else {
            check.within("humidity", |c| course.check(c));
        }
        for (i, (_, fraction)) in self.humidity.iter().enumerate() {
            let unit = Allowed::Within(0.0, 1.0);
            check.number(&format!("humidity[{i}][1]"), *fraction, unit, "a fraction, not per cent");
        }
        check.number("temperature", self.temperature, Allowed::Within(-273.0, 1000.0), "C");
    }
}

impl Keratin {
    /// The hair, with the diameters of its type or a section of its own.
    ///
    /// # Errors
    /// [`KeratinError`] for an invalid section.
    pub fn hair(&self, section: Option<Section>) -> Result<Hair, KeratinError> {
        let hair = match section.map(|section| section.semi_axes()) {
            None => Hair::of(self.kind),
            Some((a, b)) => Hair::with_diameters(2.0 * a, 2.0 * b)?,
        };
        let outside = if self.extrapolate { Outside::Mark } else { Outside::Refuse };
        Ok(hair.treated(self.treatment).of_thickness(self.thickness).outside(outside))
    }

    /// Node properties of a rod of the hair, and the laws of its sections.
    pub fn rod(
        &self,
        hair: &Hair,
        climate: &keratin::Climate,
    ) -> Result<(NodeProperties, SectionLaws), KeratinError> {
        let mut node = hair.node(climate)?;
        let laws = match self.law {
            Law::Elastic => SectionLaws::Linear,
            Law::Viscoelastic => {
                let decrement = hair.log_decrement(climate)?.value;
                let law = Viscoelastic::new(node.stiffness, &fading_modulus(decrement)?, 0.0)?;
                SectionLaws::Same(Arc::new(law))
            }
            Law::ThreeElement => {
                node.stiffness = hair.stiffness(&keratin::Climate::STANDARD)?;
                SectionLaws::Same(Arc::new(ThreeElement::section(hair, climate)?))
            }
        };
        Ok((node, laws))
    }
}

/// The power `n` of time, `t^-n`, with which a modulus must relax for free oscillations to have a
/// logarithmic decrement independent of frequency: with an inertia they are the roots of `s^2 + k
/// s^n`, which have the decrement `2 pi tan(pi n/(4 - 2 n))`.
pub fn fading_power(decrement: f64) -> f64 {
    let x = 2.0 / PI * (decrement / TAU).atan();
    2.0 * x / (1.0 + x)
}

/// A relaxation function whose free oscillations have a given logarithmic decrement between 0.01
/// and 100 rad/s, and the storage modulus 1 at 1 rad/s.
///
/// The spectrum of a power of time, [`fading_power`], goes with `tau^-n` too: here from 1e-4 to 1e4
/// s, two elements a decade, whose ripple is below a thousandth. What is slower counts as elastic.
fn fading_modulus(decrement: f64) -> Result<Relaxation, KeratinError> {
    const FIRST: f64 = 1e-4;
    const COUNT: u8 = 17;
    let ratio = 10_f64.sqrt();
    let power = fading_power(decrement);
    let time = |i: f64| FIRST * ratio.powf(i);
    let slower = time(f64::from(COUNT) - 0.5).powf(-power) / (power * ratio.ln());
    let spectrum = |scale: f64| {
        let branch = |i| {
            let time = time(f64::from(i));
            MaxwellElement { modulus: time.powf(-power) / scale, time }
        };
        Relaxation::new(slower / scale, (0..COUNT).map(branch).collect())
    };
    let [storage, _] = spectrum(1.0)?.dynamic(1.0);
    spectrum(storage)
}

impl Keratin {
    /// Density and moduli in the standard climate, where everything is measured.
    fn standard(&self) -> Result<fiber::Material, KeratinError> {
        let (hair, climate) = (self.hair(None)?, &keratin::Climate::STANDARD);
        Ok(fiber::Material {
            density: hair.density(climate).value,
            youngs_modulus: hair.bending_modulus(climate)?.value,
            shear_modulus: hair.shear_modulus(climate)?.value,
        })
    }
}

impl MaterialSpec {
    /// Density and moduli of a linearly elastic solid; keratin in the standard climate, 65 % and 23
    /// C. What is measured has none; hair is in its place, and not asked for.
    ///
    /// # Errors
    /// [`KeratinError`] for keratin with a property that is not measured.
    pub(crate) fn solid(&self) -> Result<fiber::Material, KeratinError> {
        match *self {
            Self::Hair | Self::Measured { .. } => Ok(fiber::Material::HAIR),
            Self::Elastic { density, youngs_modulus, shear_modulus } => {
                Ok(fiber::Material { density, youngs_modulus, shear_modulus })
            }
            Self::Keratin { kind, treatment, thickness, law, extrapolate } => {
                Keratin { kind, treatment, thickness, law, extrapolate }.standard()
            }
        }
    }

    /// The hair, if the material is keratin by the tables.
    #[must_use]
    pub fn keratin(&self) -> Option<Keratin> {
        let Self::Keratin { kind, treatment, thickness, law, extrapolate } = *self else {
            return None;
        };
        Some(Keratin { kind, treatment, thickness, law, extrapolate })
    }

    pub(crate) fn check(&self, check: &mut Check) {
        if let Self::Elastic { density, youngs_modulus, shear_modulus } = *self {
            check.number("density", density, Allowed::Positive, "kg/m^3");
            check.number("youngs_modulus", youngs_modulus, Allowed::Positive, "Pa");
            check.number("shear_modulus", shear_modulus, Allowed::Positive, "Pa");
        }
        if let Self::Measured { bending, torsion, linear_density, rotary_inertia } = self {
            let density = Some(*linear_density);
            check_measured(check, Some(bending), Some(*torsion), density, rotary_inertia.as_ref());
        }
    }
}

/// Reports measured numbers that are out of their range.
pub(crate) fn check_measured(
    check: &mut Check,
    bending: Option<&[f64; 2]>,
    torsion: Option<f64>,
    linear_density: Option<f64>,
    rotary_inertia: Option<&[f64; 2]>,
) {
    for (i, stiffness) in bending.into_iter().flatten().enumerate() {
        check.number(&format!("bending[{i}]"), *stiffness, Allowed::Positive, "N m^2");
    }
    if let Some(torsion) = torsion {
        check.number("torsion", torsion, Allowed::Positive, "N m^2");
    }
    if let Some(density) = linear_density {
        check.number("linear_density", density, Allowed::Positive, "kg/m");
    }
    for (i, inertia) in rotary_inertia.into_iter().flatten().enumerate() {
        check.number(&format!("rotary_inertia[{i}]"), *inertia, Allowed::Positive, "kg m");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Complex;

    #[test]
    fn a_fading_modulus_has_its_decrement_at_any_frequency() {
        for decrement in [0.4, 0.65] {
            let g = fading_modulus(decrement).expect("a model");
            let modulus = |s: Complex<f64>| {
                let branch = |b: &MaxwellElement| s * b.modulus / (s + 1.0 / b.time);
                g.branches().iter().map(branch).sum::<Complex<f64>>() + g.equilibrium()
            };
            for frequency in [0.01, 0.1, 1.0, 5.0, 30.0, 100.0] {
                // The root of `s^2 + k g(s)` near it, where the modulus changes slowly.
                let mut s = Complex::new(0.0, frequency);
                let stiffness = frequency * frequency / g.dynamic(frequency)[0];
                for _ in 0..60 {
                    s = -(-stiffness * modulus(s)).sqrt();
                }
                let found = TAU * (s.re / s.im).abs();
                // What lies beyond the spectrum takes up to 0.8 % at 100 rad/s.
                assert!((found / decrement - 1.0).abs() < 0.01, "{frequency}: {found}");
            }
            assert!((g.dynamic(1.0)[0] - 1.0).abs() < 1e-14);
        }
    }
}
