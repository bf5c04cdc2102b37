use crate::error::check;
use crate::longitudinal::check_variance;
use crate::refraction::check_index;
use crate::roughness::{azimuthal_scale, longitudinal_variance};
use crate::{CuticleTilt, Polarization, ScatteringError};
use nalgebra::Vector3;

/// What a model of scattering needs to know of a fibre, but for the shape of its section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FiberOptics {
    /// Index of refraction, in `[1, 10]`; 1.55 is keratin's.
    pub refractive_index: f64,
    /// Absorption for red, green and blue: the coefficient times the radius of the fibre, or of the
    /// circle of equal area; each at least 0. From [`crate::Pigments::absorption`] or
    /// [`crate::absorption_of_color`].
    pub absorption: Vector3<f64>,
    /// Variances of the longitudinal lobes R, TT, TRT and later, rad^2, in `[1e-8, 1e8]`.
    pub variance: [f64; 4],
    /// Scale of the logistic distribution that spreads each azimuth, rad, in `[1e-3, 1e3]`.
    pub azimuthal_scale: f64,
    /// Tilt of R, TT and TRT by the scales; later orders have none.
    pub tilt: CuticleTilt,
    /// How polarisation is treated.
    pub polarization: Polarization,
}

impl FiberOptics {
    /// Index of refraction of keratin (thesis, 6.2).
    pub const KERATIN_INDEX: f64 = 1.55;

    /// Hair with the longitudinal and azimuthal roughness `beta_m` and `beta_n`, in `[0, 1]` as in
    /// today's renderers, and scales at the angle `alpha`, rad (the thesis names 3 degrees). TT has
    /// a quarter of the variance of R, TRT and later orders four times it (Marschner et al. 2003).
    ///
    /// # Errors
    /// [`ScatteringError::Parameter`] if a value is outside its range.
    pub fn hair(
        absorption: Vector3<f64>,
        beta_m: f64,
        beta_n: f64,
        alpha: f64,
    ) -> Result<Self, ScatteringError> {
        let v = longitudinal_variance(beta_m)?;
        let optics = Self {
            refractive_index: Self::KERATIN_INDEX,
            absorption,
            variance: [v, 0.25 * v, 4.0 * v, 4.0 * v],
            azimuthal_scale: azimuthal_scale(beta_n)?,
            tilt: CuticleTilt::of_scales(Self::KERATIN_INDEX, alpha)?,
            polarization: Polarization::Averaged,
        };
        optics.validate()?;
        Ok(optics)
    }

    /// Checks that every value is in its range.
    ///
    /// # Errors
    /// [`ScatteringError::Parameter`] names the value that is not.
    pub fn validate(&self) -> Result<(), ScatteringError> {
        check_index(self.refractive_index)?;
        for value in &self.absorption {
            let allowed = *value >= 0.0 && value.is_finite();
            check("the absorption per radius", *value, "finite and not negative", allowed)?;
        }
        self.variance.iter().try_for_each(|v| check_variance(*v))?;
        let s = self.azimuthal_scale;
        check("the azimuthal scale (rad)", s, "in [1e-3, 1e3]", (1e-3..=1e3).contains(&s))
    }
}
