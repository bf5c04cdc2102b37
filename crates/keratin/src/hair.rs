//! Hair: type or given diameters, treatment, and section in a climate.

use crate::climate::{Climate, Humidity, MeasuredValue, Outside, Standing};
use crate::error::{named, not_negative, positive};
use crate::tables::{number, tables};
use crate::{KeratinError, water};
use rapunzel_fiber::Section;
use serde::{Deserialize, Serialize};
use std::str::FromStr;
use std::sync::LazyLock;

/// One micrometre in metres.
const MICRO: f64 = 1e-6;

/// Declares a list of names that are read from text, with the nearest names when misspelt.
macro_rules! names {
    ($(#[$meta:meta])* $name:ident, $what:literal { $($(#[$doc:meta])* $variant:ident = $text:literal,)* }) => {
        $(#[$meta])*
        ///
        /// In files, a value is written as its name.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(try_from = "String", into = "&'static str")]
        pub enum $name { $($(#[$doc])* $variant,)* }

        impl $name {
            /// All values, in the order of the tables.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// Name of the value, as in the tables.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $text,)* }
            }
        }

        impl TryFrom<String> for $name {
            type Error = KeratinError;

            fn try_from(name: String) -> Result<Self, KeratinError> {
                name.parse()
            }
        }

        impl From<$name> for &'static str {
            fn from(value: $name) -> Self {
                value.name()
            }
        }

        impl FromStr for $name {
            type Err = KeratinError;

            fn from_str(name: &str) -> Result<Self, KeratinError> {
                named($what, name, Self::ALL.iter().map(|x| (x.name(), *x)))
            }
        }
    };
}
pub(crate) use names;

names! {
    /// The types of hair of table 2.2. The first four are from one study, the others from another:
    /// do not compare across.
    HairType, "type of hair" {
        /// West European hair (Swift 1995).
        WestEuropean = "West European",
        /// Chinese hair (Swift 1995).
        Chinese = "Chinese",
        /// Indian hair (Swift 1995).
        Indian = "Indian",
        /// African hair (Swift 1995).
        African = "African",
        /// Caucasian hair (Robbins 2002).
        Caucasian = "Caucasian",
        /// Mongolian hair (Robbins 2002).
        Mongolian = "Mongolian",
        /// Ethiopian hair (Robbins 2002).
        Ethiopian = "Ethiopian",
    }
}

names! {
    /// The treatments of table 2.10, and none, for which table 2.9 holds.
    Treatment, "treatment" {
        /// No stated treatment: table 2.9, G = 0.89 GPa.
        None = "none",
        /// The untreated hair of table 2.10, G = 1.02 GPa: another study.
        Untreated = "untreated",
        /// Bleached.
        Bleached = "bleached",
        /// Dyed blond.
        DyedBlond = "dyed blond",
        /// Dyed black.
        DyedBlack = "dyed black",
        /// Permanently waved.
        Permed = "permed",
        /// Chemically straightened.
        Relaxed = "relaxed",
    }
}

names! {
    /// Classes of diameter with their own Young's modulus.
    Thickness, "class of diameter" {
        /// Any diameter: 3.89 GPa in tension, table 2.9.
        Any = "any",
        /// Diameters below 70 um: the mean of table 2.6, 4.59 GPa at 45 % humidity.
        Thin = "thin",
        /// Diameters above 80 um: the mean of table 2.6, 2.20 GPa at 45 % humidity.
        Thick = "thick",
    }
}

names! {
    /// The kinds of hair of table 2.1.
    Growth, "kind of hair" {
        /// Hair before birth.
        Lanugo = "lanugo",
        /// Hair at 1 to 12 years.
        Child = "child",
        /// Hair of adults.
        Adult = "adult",
        /// Hair of a thinning scalp.
        Vellus = "vellus",
    }
}

names! {
    /// The sexes of table 2.4.
    Sex, "sex" {
        /// Female.
        Female = "female",
        /// Male.
        Male = "male",
    }
}

impl Growth {
    /// The kind of hair at an age in years, by table 2.1. Of the two kinds of adults it is `Adult`,
    /// since `Vellus` depends on thinning and not on age.
    ///
    /// # Errors
    /// [`KeratinError::Negative`] for a negative age.
    pub fn at_age(years: f64) -> Result<Self, KeratinError> {
        let years = not_negative("age (a)", years)?;
        Ok(if years < 1.0 {
            Self::Lanugo
        } else if years < 13.0 {
            Self::Child
        } else {
            Self::Adult
        })
    }

    /// Largest mean length (m) and diameter (m) of the kind, table 2.1.
    #[must_use]
    pub fn size(self) -> [MeasuredValue; 2] {
        let table = &tables().growth;
        let source = table.row_source(self as usize);
        let row = &table.rows[self as usize];
        [row.l_max * 1e-2, row.r_max * MICRO]
            .map(|value| MeasuredValue::new(value, Standing::Measured, &[source]))
    }
}

/// Hairs per area of scalp, 1/m^2, table 2.4.
///
/// # Errors
/// [`KeratinError::Outside`] for an age outside 16 to 55 years, unless values are marked.
pub fn follicle_density(
    sex: Sex,
    years: f64,
    outside: Outside,
) -> Result<MeasuredValue, KeratinError> {
    let range = [16.0, 55.0];
    let standing = outside.judge("hair density", "age (a)", years, range, Standing::Measured)?;
    let index = usize::from(years >= 30.0);
    let row = &tables().follicles.rows[index];
    let value = if sex == Sex::Female { row.female } else { row.male };
    Ok(MeasuredValue::new(value * 1e4, standing, &[tables().follicles.row_source(index)]))
}

/// A hair of given type, class and treatment.
///
/// Everything that depends on the climate takes one: [`Hair::section`] and [`Hair::density`] here,
/// moduli in [`crate::moduli`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hair {
    /// Largest and smallest diameter at 65 % humidity, m.
    diameters: [f64; 2],
    kind: Option<HairType>,
    pub(crate) thickness: Thickness,
    pub(crate) treatment: Treatment,
    pub(crate) outside: Outside,
}

impl Hair {
    /// A hair of a type of table 2.2, untreated, of any thickness; values outside the measured
    /// range are refused.
    #[must_use]
    pub fn of(kind: HairType) -> Self {
        let row = &tables().diameters.rows[kind as usize];
        Self {
            diameters: [row.d_max * MICRO, row.d_min * MICRO],
            kind: Some(kind),
            thickness: Thickness::Any,
            treatment: Treatment::None,
            outside: Outside::Refuse,
        }
    }

    /// A hair with given diameters, m, at 65 % humidity.
    ///
    /// # Errors
    /// [`KeratinError::NotPositive`] for a diameter that is not positive and finite.
    pub fn with_diameters(largest: f64, smallest: f64) -> Result<Self, KeratinError> {
        let largest = positive("largest diameter (m)", largest)?;
        let smallest = positive("smallest diameter (m)", smallest)?;
        let diameters = [largest.max(smallest), largest.min(smallest)];
        Ok(Self { diameters, kind: None, ..Self::of(HairType::WestEuropean) })
    }

    /// Sets the treatment of the hair.
    #[must_use]
    pub fn treated(self, treatment: Treatment) -> Self {
        Self { treatment, ..self }
    }

    /// Sets the class of diameter whose Young's modulus is used.
    #[must_use]
    pub fn of_thickness(self, thickness: Thickness) -> Self {
        Self { thickness, ..self }
    }

    /// Sets whether values outside the measured range are refused or extrapolated.
    #[must_use]
    pub fn outside(self, outside: Outside) -> Self {
        Self { outside, ..self }
    }

    /// Largest and smallest diameter, m. Table 2.2 is taken to hold at 65 % humidity, which the
    /// thesis does not say; at other humidities hair swells by [`water::swelling`].
    #[must_use]
    pub fn diameters(&self, climate: &Climate) -> [MeasuredValue; 2] {
        let standard = climate.humidity == Humidity::STANDARD;
        let standing = if standard { Standing::Measured } else { Standing::Assumed };
        let (_, swelling) = number("diameter_swelling_max");
        let mut sources = Vec::new();
        sources.extend(self.kind.map(|kind| tables().diameters.row_source(kind as usize)));
        sources.extend((!standard).then_some(swelling));
        let factor = swelling_from_standard(climate)[0];
        self.diameters.map(|d| MeasuredValue {
            value: d * factor,
            standing,
            sources: sources.clone(),
        })
    }

    /// Cross section, m: an ellipse with its long axis along d1.
    #[must_use]
    pub fn section(&self, climate: &Climate) -> Section {
        let half = 0.5 * swelling_from_standard(climate)[0];
        Section::Ellipse { a: half * self.diameters[0], b: half * self.diameters[1] }
    }

    /// Length of the hair over its length at 65 % humidity.
    #[must_use]
    pub fn elongation(&self, climate: &Climate) -> f64 {
        swelling_from_standard(climate)[1]
    }

    /// Mass density, kg/m^3: 1300 at 65 % humidity; elsewhere computed from the mass of the water
    /// taken up and the swollen volume.
    #[must_use]
    pub fn density(&self, climate: &Climate) -> MeasuredValue {
        let (at_standard, source) = number("density");
        let mass = (1.0 + water::value_at(climate)) / (1.0 + water::value_at(&Climate::STANDARD));
        let [wide, long] = swelling_from_standard(climate);
        let standard = climate.humidity == Humidity::STANDARD;
        let standing = if standard { Standing::Measured } else { Standing::Assumed };
        let (_, saturation) = number("water_at_saturation");
        let sources = if standard { vec![source] } else { vec![source, saturation] };
        MeasuredValue { value: 1e3 * at_standard * mass / (wide * wide * long), standing, sources }
    }

    /// Mass per length of the swollen hair with its water, kg/m.
    #[must_use]
    pub fn linear_density(&self, climate: &Climate) -> f64 {
        self.density(climate).value * self.section(climate).area()
    }
}

/// Thickness and length of hair over their values at 65 % humidity.
fn swelling_from_standard(climate: &Climate) -> [f64; 2] {
    static STANDARD: LazyLock<[f64; 2]> = LazyLock::new(|| water::swelling(&Climate::STANDARD));
    let [wide, long] = water::swelling(climate);
    [wide / STANDARD[0], long / STANDARD[1]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn mass_of_dry_keratin_is_kept() {
        // Mass per rest length over 1 + R: the same keratin at any humidity.
        let hair = Hair::of(HairType::Chinese);
        let keratin = |climate: &Climate| {
            hair.linear_density(climate) * hair.elongation(climate)
                / (1.0 + water::value_at(climate))
        };
        for humidity in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let climate = Climate::new(humidity, 23.0).expect("a climate");
            assert_relative_eq!(
                keratin(&climate),
                keratin(&Climate::STANDARD),
                max_relative = 1e-14
            );
        }
    }

    #[test]
    fn nonsense_is_refused_and_names_are_suggested() {
        for d in [0.0, -80e-6, f64::NAN] {
            assert!(Hair::with_diameters(80e-6, d).is_err(), "{d}");
        }
        let error = "Chineze".parse::<HairType>().expect_err("misspelt").to_string();
        assert!(error.contains("did you mean Chinese"), "{error}");
        assert_eq!("bleached".parse(), Ok(Treatment::Bleached));
        assert!(Growth::at_age(-1.0).is_err() && Growth::at_age(f64::NAN).is_err());
        assert_eq!(Growth::at_age(12.5), Ok(Growth::Child));
        assert!(follicle_density(Sex::Male, 70.0, Outside::Refuse).is_err());
        let marked = follicle_density(Sex::Male, 70.0, Outside::Mark).expect("marked");
        assert_eq!(marked.standing, Standing::Extrapolated);
    }
}
