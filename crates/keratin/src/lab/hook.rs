//! Scott and Robbins's balanced fibre: a hair over a thin hook, a weight at either end, and the
//! distance of its legs (thesis, lines 778 to 782).

use crate::KeratinError;
use crate::error::positive;
use rapunzel_fiber::Section;
use std::f64::consts::PI;

/// Young's modulus in bending, Pa, from the tension in the legs (N), their distance (m) and the
/// area of the section (m^2): `E_B = pi T d^2 / (2 A^2)`.
///
/// # Errors
/// [`KeratinError::NotPositive`] for a reading that is not positive and finite.
///
/// # Bias
/// For a weightless hair with long legs of circular section the formula is exact: the elastica that
/// comes from the top at a right angle to its legs has `d = 2 sqrt(2 E I / T)`, and `I = A^2 / 4
/// pi`. The radius of the hook does not matter up to the curvature at the top, `d / 4`. What
/// remains:
///
/// - an elliptic section bends about its long axis, and the formula gives [`section_bias`] times E;
/// - legs of length L are cut short, by a part `exp(-L sqrt(T / E I))` of their distance;
/// - the hair's own weight adds to the tension, a part `rho A g L / T` at the top.
pub fn bending_modulus(tension: f64, distance: f64, area: f64) -> Result<f64, KeratinError> {
    positive("tension (N)", tension)?;
    positive("distance of the legs (m)", distance)?;
    positive("area of the section (m^2)", area)?;
    Ok(PI * tension * distance * distance / (2.0 * area * area))
}

/// Ratio of the formula's result to the true modulus for a hair of this section: `4 pi I / A^2`,
/// the smaller diameter over the larger.
#[must_use]
pub fn section_bias(section: &Section) -> f64 {
    let (a, b) = section.semi_axes();
    a.min(b) / a.max(b)
}
