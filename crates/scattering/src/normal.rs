use crate::error::check;
use crate::{CirclePaths, OrderShares, Polarization, ScatteringError};
use nalgebra::Vector3;

/// The normal scattering of one order of a smooth circle at the change of azimuth `azimuth`, rad,
/// per rad (thesis (6.11)): `1/2 sum A T D` over the roots, with the absorption `sigma` per radius.
/// Its integral over all azimuths is what the order scatters. Zero where no ray leaves, infinite at
/// a caustic; the models fold it with a finite width instead. Costs a search for each root.
///
/// # Errors
/// [`ScatteringError::Parameter`] if `sigma` is negative or not finite, or `azimuth` not finite.
pub fn normal_scattering(
    paths: &CirclePaths,
    p: u32,
    azimuth: f64,
    sigma: f64,
    polarization: Polarization,
) -> Result<f64, ScatteringError> {
    let allowed = sigma >= 0.0 && sigma.is_finite();
    check("the absorption per radius", sigma, "finite and not negative", allowed)?;
    check("the change of azimuth (rad)", azimuth, "finite", azimuth.is_finite())?;
    let of = |h: f64| order_leaves(paths, p, h, sigma, polarization);
    Ok(paths.roots(p, azimuth).iter().map(|root| 0.5 * of(root.h) * root.density).sum())
}

/// `A T` of one order at one offset.
fn order_leaves(
    paths: &CirclePaths,
    p: u32,
    h: f64,
    sigma: f64,
    polarization: Polarization,
) -> f64 {
    let shares = OrderShares::new(paths, h, polarization);
    let t = (-sigma * paths.segment(h)).exp();
    match p {
        0..3 => shares.absorbed(&Vector3::repeat(t))[p as usize].x,
        _ => shares.order(p) * t.powf(f64::from(p)),
    }
}
