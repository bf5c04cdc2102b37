//! What acts on all fibres: gravity, air and wind, climate.

use super::ClimateHistory;
use super::check::{Allowed, Check};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Gravity, air and climate, which act on all fibres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Environment {
    /// Acceleration of free fall, m/s^2.
    pub gravity: [f64; 3],
    /// Time in which gravity grows linearly from zero, s; 0 for at once.
    pub gravity_ramp: f64,
    /// Dynamic viscosity of the air, Pa s; 0 for none. Air has 1.8e-5. It drags a fibre as a
    /// slender body in creeping flow.
    pub viscosity: f64,
    /// Wind; it acts through the viscosity.
    pub wind: Wind,
    /// Humidity and temperature, for fibres of keratin.
    pub climate: ClimateHistory,
}

impl Default for Environment {
    fn default() -> Self {
        Self {
            gravity: [0.0, 0.0, -9.81],
            gravity_ramp: 0.0,
            viscosity: 0.0,
            wind: Wind::default(),
            climate: ClimateHistory::default(),
        }
    }
}

/// The velocity of the air, uniform in space.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Wind {
    /// Constant wind.
    Steady {
        /// Velocity, m/s.
        velocity: [f64; 3],
    },
    /// Gusts that come and go: `velocity + gust (1 - cos(2 pi t / period)) / 2`.
    Gusts {
        /// Velocity between the gusts, m/s.
        velocity: [f64; 3],
        /// Velocity added at the peak of a gust, m/s.
        gust: [f64; 3],
        /// Period of the gusts, s.
        period: f64,
    },
}

impl Default for Wind {
    fn default() -> Self {
        Self::Steady { velocity: [0.0; 3] }
    }
}

impl Environment {
    /// Gravity at time `t` (s), m/s^2, world.
    #[must_use]
    pub fn gravity_at(&self, t: f64) -> Vector3<f64> {
        let ramp = self.gravity_ramp;
        Vector3::from(self.gravity) * if t < ramp { t / ramp } else { 1.0 }
    }

    pub(crate) fn check(&self, check: &mut Check) {
        for (i, &x) in self.gravity.iter().enumerate() {
            check.number(&format!("gravity[{i}]"), x, Allowed::Within(-1e6, 1e6), "m/s^2");
        }
        check.number("gravity_ramp", self.gravity_ramp, Allowed::NonNegative, "s");
        check.number("viscosity", self.viscosity, Allowed::NonNegative, "Pa s");
        check.within("wind", |c| self.wind.check(c));
        check.within("climate", |c| self.climate.check(c));
        if self.viscosity == 0.0 && self.wind != Wind::default() {
            let message = "is 0, but wind acts through the viscosity; air has 1.8e-5 (Pa s)";
            check.refuse("viscosity", message.into());
        }
    }
}

impl Wind {
    pub(crate) fn check(&self, check: &mut Check) {
        match self {
            Self::Steady { velocity } => check.vector("velocity", velocity, "m/s"),
            Self::Gusts { velocity, gust, period } => {
                check.vector("velocity", velocity, "m/s");
                check.vector("gust", gust, "m/s");
                check.number("period", *period, Allowed::Positive, "s");
            }
        }
    }

    /// Velocity of the air at time `t` (s), m/s, world.
    #[must_use]
    pub fn at(&self, t: f64) -> Vector3<f64> {
        match self {
            Self::Steady { velocity } => Vector3::from(*velocity),
            Self::Gusts { velocity, gust, period } => {
                let strength = 0.5 * (1.0 - (std::f64::consts::TAU * t / period).cos());
                Vector3::from(*velocity) + Vector3::from(*gust) * strength
            }
        }
    }
}
