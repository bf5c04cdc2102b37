use crate::direction::{azimuth_change, inclination, turned};
use crate::draw::choose;
use crate::far_table::FarTable;
use crate::longitudinal::{Inclination, normal};
use crate::scatterer::{FiberOutline, Scatterer, cos2_half_difference, half_tangent};
use crate::{Arrival, FiberBsdf, FiberOptics, LOBES, ScatteredRay, Scattering, ScatteringError};
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};

/// The far field of the thesis, (6.14), with its errata put right but for E9: Gaussian lobes
/// `g(beta_p; theta_h - alpha_p) / 2` over `cos^2 theta_d`, R, TT and TRT alone, for comparison.
///
/// Reciprocal; a white fibre scatters 0.98 to 0.82 of the light in level light and up to 1.23 of it
/// at 85 degrees, for widths of 5 to 15 degrees. `beta_p` is half the square root of the lobe's
/// variance, `alpha_p` half of its tilt, both being for `theta_h`.
#[derive(Debug, Clone)]
pub struct MarschnerField {
    scatterer: Scatterer,
    table: FarTable,
}

impl MarschnerField {
    /// A round fibre with these optics, of which the variance of later orders does not count.
    ///
    /// # Errors
    /// [`ScatteringError`] if a value is outside its range.
    pub fn new(optics: FiberOptics) -> Result<Self, ScatteringError> {
        let scatterer = Scatterer::new(optics, FiberOutline::Circle)?;
        let table = FarTable::new(&scatterer);
        Ok(Self { scatterer, table })
    }

    fn longitudinal(&self, p: usize, theta_h: f64) -> f64 {
        let optics = &self.scatterer.optics;
        0.5 * normal(0.5 * optics.variance[p].sqrt(), theta_h - 0.5 * optics.tilt.shift[p])
    }

    /// Density of samples: the lobes' symmetric kin, even over azimuths.
    fn pdf(&self, arrival: &Arrival, r: &Inclination) -> f64 {
        let lobes = arrival.chances.iter().zip(&self.scatterer.lobes).take(3);
        lobes.map(|(chance, lobe)| chance * lobe.proposal(&arrival.inclination, r)).sum::<f64>()
            * r.cos
            / TAU
    }
}

impl FiberBsdf for MarschnerField {
    fn arrive(&self, offset: f64, from: &Vector3<f64>) -> Arrival {
        let mut arrival = Arrival::new(offset, from);
        let i = arrival.inclination;
        let [a, b, c, _] = self.table.energies.at(half_tangent(i.cos * i.cos)).absorbed;
        let [a, b, c] = [a, b, c].map(|e| e.mean());
        let sum = a + b + c;
        arrival.chances = [a, b, c, 0.0, 0.0].map(|e| if sum > 0.0 { e / sum } else { 0.0 });
        arrival
    }

    fn lobes(&self, arrival: &Arrival, to: &Vector3<f64>) -> [Vector3<f64>; LOBES] {
        let (i, r) = (arrival.inclination, inclination(to));
        let cos2 = cos2_half_difference(&i, &r);
        let normal = self.table.at(half_tangent(cos2), azimuth_change(&arrival.from, to));
        let theta_h = 0.5 * (i.sin.atan2(i.cos) + r.sin.atan2(r.cos));
        let mut lobes =
            [Vector3::repeat(normal.r), normal.tt, normal.trt, Vector3::zeros(), Vector3::zeros()];
        for (p, lobe) in lobes.iter_mut().enumerate().take(3) {
            *lobe *= self.longitudinal(p, theta_h) / cos2;
        }
        lobes
    }

    fn evaluate(&self, arrival: &Arrival, to: &Vector3<f64>) -> Scattering {
        let value = self.lobes(arrival, to).iter().sum();
        let pdf = self.pdf(arrival, &inclination(to));
        Scattering { value, pdf }.or_none()
    }

    fn sample(&self, arrival: &Arrival, random: &mut dyn FnMut() -> f64) -> Option<ScatteredRay> {
        let p = choose(&arrival.chances, random())?;
        let r = self.scatterer.lobes[p].draw(&arrival.inclination, random);
        let to = turned(&arrival.from, PI * (2.0 * random() - 1.0), &r);
        self.evaluate(arrival, &to).sampled(to, r.cos)
    }
}
