use super::SkyMap;
use super::cone::in_cone;
use crate::check::{check_light, unit};
use crate::{PathRandom, RenderError};
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// Light that comes from infinitely far away in all directions, W/(m^2 sr), for red, green and
/// blue.
#[derive(Debug, Clone)]
pub enum Sky {
    /// The same radiance everywhere.
    Constant(Vector3<f64>),
    /// A sky whose radiance goes from that at the horizon to that at the zenith linearly with the
    /// sine of the elevation, over ground of one radiance.
    Gradient {
        /// Radiance straight up.
        zenith: Vector3<f64>,
        /// Radiance of the sky at the horizon.
        horizon: Vector3<f64>,
        /// Radiance below the horizon.
        ground: Vector3<f64>,
        /// The direction of the zenith (world), of any length.
        up: Vector3<f64>,
    },
    /// Radiance by latitude and longitude.
    Map(SkyMap),
}

impl Sky {
    /// This sky with an `up` of unit length; refuses what is none.
    pub(super) fn checked(self) -> Result<Self, RenderError> {
        const RADIANCE: &str = "the radiance of the sky (W/(m^2 sr))";
        match self {
            Self::Constant(radiance) => check_light(RADIANCE, &radiance)?,
            Self::Gradient { zenith, horizon, ground, up } => {
                [zenith, horizon, ground].iter().try_for_each(|x| check_light(RADIANCE, x))?;
                let up = unit("the largest component of the up of the sky", &up)?;
                return Ok(Self::Gradient { zenith, horizon, ground, up });
            }
            Self::Map(_) => {}
        }
        Ok(self)
    }

    /// Radiance from a direction, and the density with which [`Self::draw`] draws it, per sr.
    pub(super) fn seen(&self, direction: &Vector3<f64>) -> (Vector3<f64>, f64) {
        const EVEN: f64 = 0.5 / TAU;
        match self {
            Self::Constant(radiance) => (*radiance, EVEN),
            Self::Gradient { zenith, horizon, ground, up } => {
                let sine = direction.dot(up);
                let sky = || horizon + (zenith - horizon) * sine.min(1.0);
                (if sine > 0.0 { sky() } else { *ground }, EVEN)
            }
            Self::Map(map) => map.seen(direction),
        }
    }

    pub(super) fn draw(&self, random: &mut PathRandom) -> Vector3<f64> {
        match self {
            Self::Constant(_) | Self::Gradient { .. } => in_cone(&Vector3::z(), 2.0, random.pair()),
            Self::Map(map) => map.draw(random),
        }
    }
}
