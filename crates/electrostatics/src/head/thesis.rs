//! The thesis's model of a charged head.

use crate::error::{check_charges, check_positions};
use crate::{COULOMB_CONSTANT, ElectrostaticsError};
use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::DistanceField;

/// Force (world, N) on each charge (C) at `points` (world, m) off a `head` with the charge `total`
/// (C): (4.13) of the thesis with Coulomb's constant and a signed distance d, `k q Q/d^2` along the
/// gradient of d.
///
/// For comparison only: a conductor attracts what is close, whatever its charge, and this force is
/// too large by `(r/d)^2` at the distance r from the center; 1 mm off a head of 9 cm, 8281 times.
/// [`ConductingSphere`](super::ConductingSphere) and
/// [`ConductingSurface`](super::ConductingSurface) are right.
///
/// # Errors
/// Points and charges that are not finite or do not fit, and points that are not outside.
pub fn thesis_repulsion(
    head: &dyn DistanceField,
    total: f64,
    points: &[Point3<f64>],
    charges: &[f64],
) -> Result<Vec<Vector3<f64>>, ElectrostaticsError> {
    check_positions("point", points)?;
    check_charges(charges, points.len())?;
    check_charges(&[total], 1)?;
    let force = |(index, (point, charge)): (usize, (&Point3<f64>, &f64))| {
        let sample = head.sample(point);
        if sample.value <= 0.0 {
            return Err(ElectrostaticsError::Inside { index, depth: -sample.value });
        }
        let away = sample.gradient.try_normalize(0.0).unwrap_or_default();
        Ok(COULOMB_CONSTANT * charge * total / sample.value.powi(2) * away)
    };
    points.iter().zip(charges).enumerate().map(force).collect()
}
