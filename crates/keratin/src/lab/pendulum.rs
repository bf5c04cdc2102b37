//! The torsion pendulum (thesis 2.4.8, (2.11) to (2.14)).

use crate::KeratinError;
use crate::error::positive;
use nalgebra::{Isometry3, Vector3};
use rapunzel_fiber::{Fiber, NodeProperties, Section};
use std::f64::consts::PI;

/// The bob of a torsion pendulum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bob {
    /// Mass of the bob, kg.
    pub mass: f64,
    /// Moment of inertia of the bob about the fibre, kg m^2; half as much across, as of a thin
    /// disc.
    pub inertia: f64,
}

/// A fibre of `length` (m) and of `segments` equal segments that ends in a bob: one more segment,
/// of a thousandth of the others, that carries it.
///
/// # Errors
/// Refuses a bob or a length that is not positive, and invalid arguments of [`Fiber::new`].
pub fn fiber(
    node: NodeProperties,
    length: f64,
    segments: usize,
    bob: Bob,
) -> Result<Fiber, KeratinError> {
    positive("mass of the bob (kg)", bob.mass)?;
    positive("moment of inertia of the bob (kg m^2)", bob.inertia)?;
    positive("length (m)", length)?;
    let part = length / segments as f64;
    let short = 1e-3 * part;
    let mut lengths = vec![part; segments];
    lengths.push(short);
    let mut nodes = vec![node; segments + 2];
    // A segment has the mean of its nodes.
    let last = &mut nodes[segments + 1];
    last.linear_density = 2.0 * bob.mass / short;
    last.rotary_inertia = bob.inertia / short * Vector3::new(1.0, 1.0, 2.0);
    Ok(Fiber::new(Isometry3::identity(), lengths, nodes)?)
}

/// Torsional rigidity (2.12), N m^2, the torque per twist per length: `8 pi^3 I l / T^2` with the
/// moment of inertia of the bob (kg m^2), the length of the fibre (m) and the period (s).
///
/// # Errors
/// [`KeratinError::NotPositive`] for a reading that is not positive and finite.
pub fn rigidity(inertia: f64, length: f64, period: f64) -> Result<f64, KeratinError> {
    positive("moment of inertia of the bob (kg m^2)", inertia)?;
    positive("length (m)", length)?;
    positive("period (s)", period)?;
    Ok(8.0 * PI.powi(3) * inertia * length / (period * period))
}

/// Shear modulus, Pa, from a rigidity and the area of the section, m^2: `G = Gamma / A^2` (2.13),
/// which with `A = pi d^2 / 4` is (2.11).
///
/// The formula is that of a circle. For an ellipse it gives [`section_bias`] times the modulus.
///
/// # Errors
/// [`KeratinError::NotPositive`] for an area that is not positive and finite.
pub fn shear_modulus(rigidity: f64, area: f64) -> Result<f64, KeratinError> {
    positive("area of the section (m^2)", area)?;
    Ok(rigidity / (area * area))
}

/// Ratio of the result of (2.13) to the true modulus for this section:
/// `2 pi J / A^2 = 2 a b / (a^2 + b^2)`.
#[must_use]
pub fn section_bias(section: &Section) -> f64 {
    2.0 * PI * section.torsion_constant() / section.area().powi(2)
}

/// The modulus of the cuticle, Pa, from that of the whole fibre and of its cortex and the diameters
/// of cortex and fibre (thesis, line 863): circular sections, side by side in torsion.
///
/// # Errors
/// [`KeratinError::NotPositive`] unless the cuticle has a thickness.
pub fn cuticle_modulus(
    whole: f64,
    cortex: f64,
    inner: f64,
    outer: f64,
) -> Result<f64, KeratinError> {
    positive("diameter of the cortex (m)", inner)?;
    positive("thickness of the cuticle (m)", outer - inner)?;
    let (d1, d2) = (inner.powi(4), outer.powi(4));
    Ok((whole * d2 - cortex * d1) / (d2 - d1))
}
