use crate::ScatteringError;
use crate::error::check;
use crate::exponential::exponentials;
use std::f64::consts::PI;

/// Variance of the longitudinal lobe, rad^2, of a fibre of the roughness `beta` in `[0, 1]`, evenly
/// felt: `(0.726 b + 0.812 b^2 + 3.7 b^20)^2` (Chiang et al. 2016, (7)).
///
/// # Errors
/// [`ScatteringError::Parameter`] if `beta` is not in `[0, 1]`.
pub fn longitudinal_variance(beta: f64) -> Result<f64, ScatteringError> {
    check("the longitudinal roughness", beta, "in [0, 1]", (0.0..=1.0).contains(&beta))?;
    Ok((0.726 * beta + 0.812 * beta.powi(2) + 3.7 * beta.powi(20)).powi(2))
}

/// Scale of the logistic azimuthal lobe, rad, of a fibre of the roughness `beta` in `[0, 1]`:
/// `sqrt(pi / 8) (0.265 b + 1.194 b^2 + 5.372 b^22)` (Chiang et al. 2016, (8)).
///
/// # Errors
/// [`ScatteringError::Parameter`] if `beta` is not in `[0, 1]`.
pub fn azimuthal_scale(beta: f64) -> Result<f64, ScatteringError> {
    check("the azimuthal roughness", beta, "in [0, 1]", (0.0..=1.0).contains(&beta))?;
    Ok((PI / 8.0).sqrt() * (0.265 * beta + 1.194 * beta.powi(2) + 5.372 * beta.powi(22)))
}

/// The logistic distribution of an angle, cut to `[-pi, pi]` and scaled to the integral 1: it
/// spreads an azimuth, so that a caustic keeps its energy and has a finite height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Logistic {
    scale: f64,
    /// `1 / scale`.
    sharpness: f64,
    /// Cumulative distribution at `-pi` before the cut.
    below: f64,
    /// `1 / (scale (1 - 2 below))`.
    height: f64,
}

impl Logistic {
    pub(crate) fn new(scale: f64) -> Self {
        let below = 1.0 / (1.0 + (PI / scale).exp());
        Self { scale, sharpness: 1.0 / scale, below, height: 1.0 / (scale * (1.0 - 2.0 * below)) }
    }

    /// Densities at angles in `[-pi, pi]`, per rad.
    pub(crate) fn densities(&self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        // Four exponentials are as quick as three.
        let all = exponentials([a, b, c, 0.0].map(|angle| -angle.abs() * self.sharpness));
        [0, 1, 2].map(|p| self.height * all[p] / ((1.0 + all[p]) * (1.0 + all[p])))
    }

    /// The angle below which the share `u`, in `[0, 1)`, lies.
    pub(crate) fn quantile(&self, u: f64) -> f64 {
        let share = self.below + u * (1.0 - 2.0 * self.below);
        (-self.scale * (1.0 / share - 1.0).ln()).clamp(-PI, PI)
    }
}
