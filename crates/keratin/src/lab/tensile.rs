//! The tensile test and its hysteresis (thesis 2.4.1, 2.4.3).

use crate::KeratinError;
use crate::law::Tension;

/// A point of a stress-strain curve: strain, and stress in Pa.
pub type CurvePoint = [f64; 2];

/// Stretches a fibre to a strain in equal parts, or until it breaks. With a strain below the
/// present one, the fibre is unloaded.
pub fn stretch(fiber: &mut Tension, strain: f64, parts: u32) -> Vec<CurvePoint> {
    let from = fiber.strain();
    let mut curve = vec![[from, fiber.stress()]];
    for i in 1..=parts {
        let next = from + (strain - from) * f64::from(i) / f64::from(parts);
        let Some(stress) = fiber.strain_to(next) else { break };
        curve.push([next, stress]);
    }
    curve
}

/// The slope of a curve between two strains, Pa, by least squares: in the Hookean region, Young's
/// modulus.
///
/// # Errors
/// [`KeratinError::Readings`] for fewer than two points between the strains.
pub fn modulus(curve: &[CurvePoint], from: f64, to: f64) -> Result<f64, KeratinError> {
    let inside: Vec<_> = curve.iter().filter(|[e, _]| (from..=to).contains(e)).collect();
    if inside.len() < 2 {
        let protocol = "a modulus by least squares";
        return Err(KeratinError::Readings { protocol, needed: 2, found: inside.len() });
    }
    let count = inside.len() as f64;
    let mean = |i: usize| inside.iter().map(|p| p[i]).sum::<f64>() / count;
    let (e, s) = (mean(0), mean(1));
    let both: f64 = inside.iter().map(|p| (p[0] - e) * (p[1] - s)).sum();
    let own: f64 = inside.iter().map(|p| (p[0] - e).powi(2)).sum();
    Ok(both / own)
}

/// The area below a curve, Pa: work per volume, negative on unloading.
#[must_use]
pub fn work(curve: &[CurvePoint]) -> f64 {
    curve.windows(2).map(|w| 0.5 * (w[0][1] + w[1][1]) * (w[1][0] - w[0][0])).sum()
}

/// The hysteresis ratio: the work of extension over that of recovery (thesis, line 660).
#[must_use]
pub fn hysteresis_ratio(extension: &[CurvePoint], recovery: &[CurvePoint]) -> f64 {
    -work(extension) / work(recovery)
}
