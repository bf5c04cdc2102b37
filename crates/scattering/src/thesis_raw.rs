//! Equations of chapter 6 as they are printed, where they are finite, to show what each erratum
//! changes. Nothing else in this crate uses them.

use crate::error::check;
use crate::longitudinal::normal;
use crate::refraction::{check_index, cosine};
use crate::{BravaisIndices, CirclePaths, ScatteringError, equivalent_index};

/// How the Fresnel terms of a skew ray can be read (thesis, after (6.9)).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FresnelReading {
    /// `n''` as printed, with `cos^2 theta` (erratum E2).
    PrintedIndex,
    /// The right `n''`, but with an angle of refraction of its own (erratum E3).
    OwnAngle,
    /// `n'` alone, in both terms (erratum E3).
    OneIndex,
}

/// `n''` as printed: `n^2 cos^2 theta / sqrt(n^2 - sin^2 theta)` (erratum E2).
///
/// # Errors
/// As [`BravaisIndices::new`].
pub fn parallel_index(n: f64, theta: f64) -> Result<f64, ScatteringError> {
    Ok(BravaisIndices::new(n, theta)?.parallel * theta.cos())
}

/// Reflectance of unpolarised light at the offset `h`, by one of the readings.
///
/// # Errors
/// As [`BravaisIndices::new`].
pub fn reflectance(
    reading: FresnelReading,
    n: f64,
    theta: f64,
    h: f64,
) -> Result<f64, ScatteringError> {
    let indices = BravaisIndices::new(n, theta)?;
    let (cos_i, of) = (cosine(h), |n: f64| cosine((h / n).clamp(-1.0, 1.0)));
    let perpendicular = of(indices.perpendicular);
    let (parallel, cos_t) = match reading {
        FresnelReading::PrintedIndex => (parallel_index(n, theta)?, perpendicular),
        FresnelReading::OwnAngle => (indices.parallel, of(indices.parallel)),
        FresnelReading::OneIndex => (indices.perpendicular, perpendicular),
    };
    let square = |a: f64, b: f64| if a + b > 0.0 { ((a - b) / (a + b)).powi(2) } else { 1.0 };
    let s = square(cos_i, indices.perpendicular * perpendicular);
    Ok(0.5 * (s + square(parallel * cos_i, cos_t)))
}

/// What one segment inside transmits at the offset `h`, with the absorption `sigma` per radius over
/// `sin theta` as printed (erratum E1): nothing at all in level light.
///
/// # Errors
/// As [`BravaisIndices::new`], and if `sigma` is negative or not finite.
pub fn transmission(n: f64, theta: f64, h: f64, sigma: f64) -> Result<f64, ScatteringError> {
    let index = BravaisIndices::new(n, theta)?.perpendicular;
    let allowed = sigma >= 0.0 && sigma.is_finite();
    check("the absorption per radius", sigma, "finite and not negative", allowed)?;
    let length = 2.0 * cosine(h / index) / theta.sin().abs();
    Ok(if sigma > 0.0 { (-sigma * length).exp() } else { 1.0 })
}

/// The near field (6.20) once its offsets are integrated out: the density of rays counts twice
/// (erratum E5). Without absorption, per rad and per unit of `h`; infinite at a caustic.
///
/// # Errors
/// As [`BravaisIndices::new`].
pub fn near_normal_scattering(
    p: u32,
    n: f64,
    theta: f64,
    azimuth: f64,
) -> Result<f64, ScatteringError> {
    let paths = CirclePaths::new(n, theta)?;
    let mut sum = 0.0;
    for root in paths.roots(p, azimuth) {
        let share = share(p, reflectance(FresnelReading::PrintedIndex, n, theta, root.h)?);
        sum += 0.5 * share * root.density * root.density;
    }
    Ok(sum)
}

/// `A` of (6.7) and (6.8) by the reflectance.
fn share(p: u32, f: f64) -> f64 {
    if p == 0 { f } else { (1.0 - f).powi(2) * f.powf(f64::from(p) - 1.0) }
}

/// The far field (6.14) as printed: with the errata E1, E2, E8 and E11.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrintedFarField {
    /// Index of refraction, in `[1, 10]`.
    pub refractive_index: f64,
    /// Absorption per radius, at least 0.
    pub absorption: f64,
    /// Widths `beta` of R, TT and TRT, rad.
    pub widths: [f64; 3],
    /// Shifts `alpha` of R, TT and TRT, rad.
    pub shifts: [f64; 3],
    /// Ratio of the axis along d1 to that along d2, in `[1/16, 16]`.
    pub axis_ratio: f64,
}

impl PrintedFarField {
    /// `S` between the inclinations and azimuths `[theta, phi]` of light and eye, rad. At a caustic
    /// it is infinite.
    ///
    /// # Errors
    /// [`ScatteringError::Parameter`] if a field is out of its range, or `theta_d` a right angle.
    pub fn value(&self, light: [f64; 2], eye: [f64; 2]) -> Result<f64, ScatteringError> {
        check_index(self.refractive_index)?;
        for width in self.widths {
            check(
                "the width (rad)",
                width,
                "positive and finite",
                width > 0.0 && width.is_finite(),
            )?;
        }
        let (theta_h, theta_d) = (0.5 * (light[0] + eye[0]), 0.5 * (eye[0] - light[0]));
        let phi_h = 0.5 * (light[1] + eye[1]);
        let mut sum = 0.0;
        for p in 0..3 {
            // Only TRT sees that the section is an ellipse.
            let n = if p < 2 {
                self.refractive_index
            } else {
                equivalent_index(self.refractive_index, self.axis_ratio, phi_h)?
            };
            let order = p as usize;
            let longitudinal = normal(self.widths[order], theta_h - self.shifts[order]);
            for root in CirclePaths::new(n, theta_d)?.roots(p, eye[1] - light[1]) {
                let f = reflectance(FresnelReading::PrintedIndex, n, theta_d, root.h)?;
                let t = transmission(n, theta_d, root.h, self.absorption)?;
                let leaves = 0.5 * share(p, f) * t.powf(f64::from(p)) * root.density;
                sum += longitudinal * leaves / theta_d.cos().powi(2);
            }
        }
        Ok(sum)
    }
}
