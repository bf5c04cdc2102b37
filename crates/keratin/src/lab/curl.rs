//! Waves and curls: Robbins and Reich's waviness (thesis 2.3.3) and curl retention (2.4.4).

use crate::KeratinError;
use crate::climate::Climate;
use crate::error::positive;
use crate::hair::Hair;
use crate::law::ThreeElement;
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::Fiber;
use rapunzel_fiber::generate::Helix;

/// Waviness `C = n l_t / l_c` of a hair with `maxima` waves whose length is `natural` (m) as it
/// lies and `stretched` (m) under a weight of 1 g.
///
/// # Errors
/// [`KeratinError::NotPositive`] for a length that is not positive and finite.
pub fn waviness(maxima: usize, stretched: f64, natural: f64) -> Result<f64, KeratinError> {
    positive("stretched length (m)", stretched)?;
    positive("natural length (m)", natural)?;
    Ok(maxima as f64 * stretched / natural)
}

/// Number of maxima of a curve as seen from the side: how often its distance along `side` from the
/// straight line between its ends has a maximum.
#[must_use]
pub fn maxima(curve: &[Point3<f64>], side: &Vector3<f64>) -> usize {
    let (Some(first), Some(last)) = (curve.first(), curve.last()) else { return 0 };
    let count = curve.len() as f64;
    let height = |(i, p): (usize, &Point3<f64>)| {
        let line = first.coords.lerp(&last.coords, i as f64 / count);
        (p.coords - line).dot(side)
    };
    let heights: Vec<f64> = curve.iter().enumerate().map(height).collect();
    heights.windows(3).filter(|w| w[1] > w[0] && w[1] >= w[2]).count()
}

/// Curl retention index `(L_inf - L) / L_inf` of a curl that hangs `hanging` metres deep and is
/// `straight` metres long unwound; the thesis measures it after three hours.
///
/// # Errors
/// [`KeratinError::NotPositive`] for a length that is not positive and finite.
pub fn retention(straight: f64, hanging: f64) -> Result<f64, KeratinError> {
    positive("straight length (m)", straight)?;
    positive("hanging length (m)", hanging)?;
    Ok((straight - hanging) / straight)
}

/// Protocol of a water wave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaterWave {
    /// Helix on which the hair is wound.
    pub mandrel: Helix,
    /// Time for which it is held wet, s.
    pub wet: f64,
    /// Climate in which it is dried.
    pub air: Climate,
    /// Time for which it is dried, s.
    pub drying: f64,
    /// Time for which it then hangs in the climate of the test, s.
    pub incubation: f64,
}

impl WaterWave {
    /// A water wave held wet for ten minutes, dried for an hour in the standard climate at 50 %
    /// humidity, and kept for three hours; the thesis gives only the last time.
    ///
    /// # Errors
    /// Never fails: 50 % is a valid humidity.
    pub fn on(mandrel: Helix) -> Result<Self, KeratinError> {
        let air = Climate::new(0.5, Climate::STANDARD.temperature.celsius())?;
        Ok(Self { mandrel, wet: 600.0, air, drying: 3600.0, incubation: 3.0 * 3600.0 })
    }

    /// Fraction of the winding that an unloaded hair keeps after the incubation in a climate.
    ///
    /// # Errors
    /// As [`Hair::bending_modulus`].
    pub fn set(&self, hair: &Hair, climate: Climate) -> Result<f64, KeratinError> {
        let mut wave = ThreeElement::water_wave(hair, self.wet, self.air, self.drying)?;
        wave.enter(climate);
        Ok(wave.release(self.incubation))
    }

    /// The unloaded curl after the incubation, hanging from the origin: its natural curvature is
    /// the set times the curvature of the mandrel, its stiffness and mass are those of the hair in
    /// the climate.
    ///
    /// # Errors
    /// The errors of [`Hair::bending_modulus`], and invalid lengths and mandrels.
    pub fn curl(
        &self,
        hair: &Hair,
        climate: Climate,
        length: f64,
        segments: usize,
    ) -> Result<Fiber, KeratinError> {
        positive("length (m)", length)?;
        let part = length / segments.max(1) as f64;
        let down = rapunzel_fiber::generate::root_pose(Point3::origin(), &-Vector3::z())?;
        let straight =
            Fiber::new(down, vec![part; segments], vec![hair.node(&climate)?; segments + 1])?;
        let wound = self.mandrel.bend(straight)?;
        let set = self.set(hair, climate)?;
        let kappa = set * wound.nodes()[0].natural_curvature;
        // Curvature and torsion loosen alike, so the angle of the helix stays: its axis hangs down.
        Ok(wound.with_natural_curvature(|_| kappa)?)
    }
}
