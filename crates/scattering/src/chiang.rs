use crate::bessel::scaled_bessel_0;
use crate::circle::wrapped;
use crate::direction::{azimuth_change, inclination, turned};
use crate::draw::choose;
use crate::exponential::exponentials;
use crate::longitudinal::{Inclination, spherical_exponents, spherical_height};
use crate::scatterer::{FiberOutline, Scatterer};
use crate::{Arrival, FiberBsdf, FiberOptics, LOBES, ScatteredRay, Scattering, ScatteringError};
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};

/// The near field of today's renderers (Chiang et al. 2016), for comparison with them: lobes of
/// d'Eon, turned by the tilt, attenuated at the inclination where the path arrived, on a round
/// fibre.
///
/// It conserves energy at every offset and inclination, and the weight of every sample is the
/// albedo, but it is not reciprocal: exchanged directions differ by tens of per cent.
#[derive(Debug, Clone)]
pub struct ChiangField {
    scatterer: Scatterer,
    /// Of the lobes.
    heights: [f64; 4],
}

impl ChiangField {
    /// A round fibre with these optics.
    ///
    /// # Errors
    /// [`ScatteringError`] if a value is outside its range.
    pub fn new(optics: FiberOptics) -> Result<Self, ScatteringError> {
        let scatterer = Scatterer::new(optics, FiberOutline::Circle)?;
        Ok(Self { scatterer, heights: optics.variance.map(spherical_height) })
    }

    /// The inclination around whose mirror image a lobe lies.
    fn turned_back(&self, p: usize, i: &Inclination) -> Inclination {
        i.before(self.scatterer.lobes[p].shift())
    }

    /// The lobes times the cosine of `to`, without their energies: densities, per sr.
    fn densities(&self, arrival: &Arrival, to: &Vector3<f64>) -> [f64; 4] {
        let (r, change) = (inclination(to), azimuth_change(&arrival.from, to));
        let off = arrival.rays.azimuth.map(|of| wrapped(change - of));
        let [a, b, c] = self.scatterer.azimuthal.densities(off);
        let spread = [a, b, c, TAU.recip()];
        let exponents = [0, 1, 2, 3].map(|p| {
            let k = self.scatterer.optics.variance[p].recip();
            spherical_exponents(k, &self.turned_back(p, &arrival.inclination), &r)
        });
        let peaks = exponentials(exponents.map(|[exponent, _]| exponent));
        let bessel = exponents.map(|[_, argument]| scaled_bessel_0(argument));
        [0, 1, 2, 3].map(|p| self.heights[p] * peaks[p] * bessel[p] * spread[p])
    }
}

impl FiberBsdf for ChiangField {
    fn arrive(&self, offset: f64, from: &Vector3<f64>) -> Arrival {
        let mut arrival = Arrival::new(offset, from);
        let cos = arrival.inclination.cos;
        let cone = self.scatterer.cone(cos * cos);
        arrival.rays = self.scatterer.rays(cone, from, &arrival.offset);
        let [a, b, c, d] = arrival.rays.energy.map(|energy| energy.mean());
        let sum = a + b + c + d;
        arrival.chances = [a, b, c, d, 0.0].map(|e| if sum > 0.0 { e / sum } else { 0.0 });
        arrival
    }

    fn lobes(&self, arrival: &Arrival, to: &Vector3<f64>) -> [Vector3<f64>; LOBES] {
        let densities = self.densities(arrival, to);
        let cos = inclination(to).cos;
        let [a, b, c, d] = [0, 1, 2, 3].map(|p| arrival.rays.energy[p] * (densities[p] / cos));
        [a, b, c, d, Vector3::zeros()]
    }

    fn evaluate(&self, arrival: &Arrival, to: &Vector3<f64>) -> Scattering {
        let densities = self.densities(arrival, to);
        let lobes =
            arrival.rays.energy.iter().zip(&densities).map(|(energy, density)| energy * *density);
        let value = lobes.sum::<Vector3<f64>>() / inclination(to).cos;
        let pdf = arrival.chances.iter().zip(&densities).map(|(chance, q)| chance * q).sum();
        Scattering { value, pdf }.or_none()
    }

    /// The inclination by d'Eon's inverse of the normal distribution on the sphere.
    fn sample(&self, arrival: &Arrival, random: &mut dyn FnMut() -> f64) -> Option<ScatteredRay> {
        let p = choose(&arrival.chances, random())?;
        let (pole, v) =
            (self.turned_back(p, &arrival.inclination), self.scatterer.optics.variance[p]);
        // 1 - cos of the angle to the mirrored direction.
        let u = random();
        let t = (-v * (u + (1.0 - u) * (-2.0 / v).exp()).ln()).clamp(0.0, 2.0);
        let side = (TAU * random()).cos() * (t * (2.0 - t)).sqrt();
        let sin = (side * pole.cos - (1.0 - t) * pole.sin).clamp(-1.0, 1.0);
        let r = Inclination { sin, cos: (1.0 - sin * sin).sqrt() };
        let change = match arrival.rays.azimuth.get(p) {
            Some(of) => of + self.scatterer.azimuthal.quantile(random()),
            None => PI * (2.0 * random() - 1.0),
        };
        let to = turned(&arrival.from, change, &r);
        self.evaluate(arrival, &to).sampled(to, r.cos)
    }
}
