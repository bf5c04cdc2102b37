//! Humidity and temperature of the air, and the standing of a value between measured and guessed.

use crate::KeratinError;
use crate::tables::Source;
use serde::{Deserialize, Serialize};

/// Relative humidity of the air, a fraction in `[0, 1]`.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Humidity(f64);

impl Humidity {
    /// Relative humidity 0: no water at all.
    pub const DRY: Self = Self(0.0);
    /// Relative humidity 1: saturated air, or immersed hair.
    pub const SATURATED: Self = Self(1.0);
    /// Relative humidity 0.65, at which the thesis's tables 2.9 and 2.10 hold; diameters are
    /// assumed to hold there too.
    pub const STANDARD: Self = Self(0.65);

    /// Creates a relative humidity from a fraction.
    ///
    /// # Errors
    /// [`KeratinError::Humidity`] outside `[0, 1]`.
    pub fn new(fraction: f64) -> Result<Self, KeratinError> {
        if (0.0..=1.0).contains(&fraction) {
            Ok(Self(fraction))
        } else {
            Err(KeratinError::Humidity(fraction))
        }
    }

    /// Relative humidity as a fraction.
    #[must_use]
    pub fn fraction(self) -> f64 {
        self.0
    }
}

impl TryFrom<f64> for Humidity {
    type Error = KeratinError;

    fn try_from(fraction: f64) -> Result<Self, KeratinError> {
        Self::new(fraction)
    }
}

impl From<Humidity> for f64 {
    fn from(humidity: Humidity) -> Self {
        humidity.0
    }
}

/// A temperature in degrees Celsius.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Temperature(f64);

impl Temperature {
    /// 23 C, at which most of the tables hold.
    pub const ROOM: Self = Self(23.0);
    /// Temperature 0 C in kelvin.
    const ZERO: f64 = 273.15;

    /// Creates a temperature from degrees Celsius.
    ///
    /// # Errors
    /// [`KeratinError::Temperature`] at or below absolute zero, and for a value that is not finite.
    pub fn new(celsius: f64) -> Result<Self, KeratinError> {
        if celsius > -Self::ZERO && celsius.is_finite() {
            Ok(Self(celsius))
        } else {
            Err(KeratinError::Temperature(celsius))
        }
    }

    /// Temperature in degrees Celsius.
    #[must_use]
    pub fn celsius(self) -> f64 {
        self.0
    }

    /// Temperature in kelvin.
    #[must_use]
    pub fn kelvin(self) -> f64 {
        self.0 + Self::ZERO
    }
}

impl TryFrom<f64> for Temperature {
    type Error = KeratinError;

    fn try_from(celsius: f64) -> Result<Self, KeratinError> {
        Self::new(celsius)
    }
}

impl From<Temperature> for f64 {
    fn from(temperature: Temperature) -> Self {
        temperature.0
    }
}

/// Sorption branch: the direction from which hair came to its present humidity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum SorptionBranch {
    /// From drier air, taking up water.
    #[default]
    Absorption,
    /// From more humid air, giving off water: hair holds a little more water on this branch.
    Desorption,
}

/// State of the air around hair that is in equilibrium with it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Climate {
    /// Relative humidity of the air.
    pub humidity: Humidity,
    /// Temperature of the air.
    pub temperature: Temperature,
    /// Sorption branch on which the humidity was reached.
    #[serde(default)]
    pub branch: SorptionBranch,
}

impl Climate {
    /// Air of 65 % humidity and 23 C.
    pub const STANDARD: Self = Self {
        humidity: Humidity::STANDARD,
        temperature: Temperature::ROOM,
        branch: SorptionBranch::Absorption,
    };
    /// Water of 23 C.
    pub const WET: Self = Self {
        humidity: Humidity::SATURATED,
        temperature: Temperature::ROOM,
        branch: SorptionBranch::Absorption,
    };

    /// Creates a climate from a humidity (fraction) and a temperature (C), reached from drier air.
    ///
    /// # Errors
    /// The errors of [`Humidity::new`] and [`Temperature::new`].
    pub fn new(humidity: f64, celsius: f64) -> Result<Self, KeratinError> {
        Ok(Self {
            humidity: Humidity::new(humidity)?,
            temperature: Temperature::new(celsius)?,
            branch: SorptionBranch::Absorption,
        })
    }
}

/// Treatment of values outside the measured range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Outside {
    /// Refuse, with an error that names the measured range.
    #[default]
    Refuse,
    /// Extrapolate the nearest curve, and mark the value as [`Standing::Extrapolated`].
    Mark,
}

impl Outside {
    /// Standing of a value of `quantity` at the point `value`, where `of` has been measured in
    /// `range`.
    pub(crate) fn judge(
        self,
        quantity: &'static str,
        of: &'static str,
        value: f64,
        range: [f64; 2],
        inside: Standing,
    ) -> Result<Standing, KeratinError> {
        if (range[0]..=range[1]).contains(&value) {
            Ok(inside)
        } else if self == Self::Mark {
            Ok(Standing::Extrapolated)
        } else {
            Err(KeratinError::Outside { quantity, of, value, range })
        }
    }
}

/// Reliability of a value: the later the variant, the farther from a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Standing {
    /// Measured in these conditions.
    Measured,
    /// Interpolated between measurements.
    Interpolated,
    /// Based on a curve, a material or a reading of the thesis that the documentation names as
    /// assumed.
    Assumed,
    /// Extrapolated beyond the conditions of all measurements.
    Extrapolated,
}

/// A value with its reliability and its sources.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredValue {
    /// The value, in SI units.
    pub value: f64,
    /// Reliability of the value.
    pub standing: Standing,
    /// Numbers of the thesis from which the value is computed.
    pub sources: Vec<Source>,
}

impl MeasuredValue {
    /// A value from one number and its sources.
    pub(crate) fn new(value: f64, standing: Standing, sources: &[Source]) -> Self {
        Self { value, standing, sources: sources.to_vec() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nonsense_is_refused() {
        for humidity in [-0.01, 1.01, 65.0, f64::NAN] {
            assert!(Humidity::new(humidity).is_err(), "{humidity}");
        }
        for celsius in [-273.15, -300.0, f64::INFINITY, f64::NAN] {
            assert!(Temperature::new(celsius).is_err(), "{celsius}");
        }
        assert!(ron::from_str::<Climate>("(humidity: 65, temperature: 23)").is_err());
        let read: Climate = ron::from_str("(humidity: 0.65, temperature: 23)").expect("a climate");
        assert_eq!(read, Climate::STANDARD);
    }
}
