//! Humidity and temperature, and where a value stands between measured and guessed.

use crate::KeratinError;
use crate::tables::Source;
use serde::{Deserialize, Serialize};

/// Relative humidity of the air, a fraction in `[0, 1]`.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Humidity(f64);

impl Humidity {
    /// No water at all.
    pub const DRY: Self = Self(0.0);
    /// Saturated air, or immersed.
    pub const SATURATED: Self = Self(1.0);
    /// The 65 % at which the thesis's tables 2.9 and 2.10 hold, and diameters are taken to.
    pub const STANDARD: Self = Self(0.65);

    /// A relative humidity.
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

    /// The fraction.
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
    /// 0 C in kelvin.
    const ZERO: f64 = 273.15;

    /// A temperature in degrees Celsius.
    ///
    /// # Errors
    /// [`KeratinError::Temperature`] at absolute zero, below it, and for what is not finite.
    pub fn new(celsius: f64) -> Result<Self, KeratinError> {
        if celsius > -Self::ZERO && celsius.is_finite() {
            Ok(Self(celsius))
        } else {
            Err(KeratinError::Temperature(celsius))
        }
    }

    /// In degrees Celsius.
    #[must_use]
    pub fn celsius(self) -> f64 {
        self.0
    }

    /// In kelvin.
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

/// From which side hair came to the humidity that it has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum SorptionBranch {
    /// From drier air.
    #[default]
    Absorption,
    /// From more humid air: it holds a little more water.
    Desorption,
}

/// The air around hair that has come to equilibrium with it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Climate {
    /// Relative humidity.
    pub humidity: Humidity,
    /// Temperature.
    pub temperature: Temperature,
    /// From which side it was reached.
    #[serde(default)]
    pub branch: SorptionBranch,
}

impl Climate {
    /// 65 % at 23 C.
    pub const STANDARD: Self = Self {
        humidity: Humidity::STANDARD,
        temperature: Temperature::ROOM,
        branch: SorptionBranch::Absorption,
    };
    /// In water of 23 C.
    pub const WET: Self = Self {
        humidity: Humidity::SATURATED,
        temperature: Temperature::ROOM,
        branch: SorptionBranch::Absorption,
    };

    /// A humidity (fraction) and a temperature (C), reached from drier air.
    ///
    /// # Errors
    /// Those of [`Humidity::new`] and [`Temperature::new`].
    pub fn new(humidity: f64, celsius: f64) -> Result<Self, KeratinError> {
        Ok(Self {
            humidity: Humidity::new(humidity)?,
            temperature: Temperature::new(celsius)?,
            branch: SorptionBranch::Absorption,
        })
    }
}

/// What to do where nobody measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Outside {
    /// Refuse, with the range that is measured.
    #[default]
    Refuse,
    /// Continue the nearest curve, and mark the value as [`Standing::Extrapolated`].
    Mark,
}

impl Outside {
    /// The standing of a value of `quantity` at `value`, measured for `of` in `range`.
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

/// How far a value is from a measurement; the later, the farther.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Standing {
    /// As measured, in these conditions.
    Measured,
    /// Between measurements.
    Interpolated,
    /// By a curve, a material or a reading that the documentation names as assumed.
    Assumed,
    /// Outside of the conditions of all measurements.
    Extrapolated,
}

/// A value, how far it is to be trusted, and where it comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredValue {
    /// The value, SI.
    pub value: f64,
    /// How far it is from a measurement.
    pub standing: Standing,
    /// The numbers of the thesis that it is made of.
    pub sources: Vec<Source>,
}

impl MeasuredValue {
    /// A value from one number.
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
