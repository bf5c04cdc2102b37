use crate::balance::{Balance, BalancePoint};
use crate::circle::wrapped;
use crate::direction::{azimuth_change, inclination, turned};
use crate::draw::{MOST_TRIES, choose};
use crate::energy::EnergyTable;
use crate::longitudinal::Inclination;
use crate::offsets::OffsetTable;
use crate::scatterer::{FiberOutline, Rays, Scatterer, cos2_half_difference};
use crate::{
    Arrival, FiberBsdf, FiberOptics, LOBES, ScatteredRay, Scattering, ScatteringError,
    SymmetricLobe,
};
use nalgebra::Vector3;
use rapunzel_fiber::Section;
use std::f64::consts::{PI, TAU};

/// The near field: scattering at the very offset that was hit (thesis 6.4), for round and
/// elliptical fibres.
///
/// The thesis's (6.20), with its errata E4 to E6, is `A_p(h) T_p(h) delta(h_r + h_i) delta(dphi -
/// dphi_p(h)) / cos^2 theta_d`: no density of rays, no half, no sum over roots, which come by
/// themselves when `h` is integrated out. The offset of the hit is one of both `h`, so the first
/// delta is used up; the second becomes a logistic distribution, the one over inclinations
/// [`crate::SymmetricLobe`]. Later orders leave to all azimuths alike. The mean over the width is
/// [`crate::FarField`]. Where along the fibre light leaves (6.21) is left out: within two radii or
/// so.
///
/// Reciprocal for a circle: exchange of the directions and of `h` with the offset at which the ray
/// leaves, `-h`. For an ellipse that holds for the rays, not for the azimuths beside them over
/// which they are spread.
///
/// White fibres scatter all light over their width. At one offset alone, lobes of different widths
/// and tilts do not: with a roughness of 0.3 and scales at 3 degrees 0.99 to 1.01 of it in level
/// light, 0.89 to 1.15 at 60 degrees and up to 1.4 at the very edge at 85. For an ellipse, the
/// balance of energy is that of the mean over its azimuths.
///
/// Samples of a circle weigh what is scattered at their offset, to 2e-4; those of an ellipse
/// deviate from that by a seventh to a third.
///
/// Building costs some 0.12 s (an ellipse 0.4 s), an evaluation a third of a microsecond (an
/// ellipse three quarters), a sample twice that, without allocation.
#[derive(Debug, Clone)]
pub struct NearField {
    scatterer: Scatterer,
    balance: Balance,
    /// For a circle.
    offsets: Option<OffsetTable>,
}

/// What an evaluation needs of both directions.
struct ScatteringPair {
    /// Lobes times their scale, over inclinations.
    lobes: [f64; 4],
    rays: Rays,
    balance: BalancePoint,
}

impl NearField {
    /// A fibre of the `section` with these optics; of the section only the shape counts, its axes
    /// lie along d1 and d2.
    ///
    /// # Errors
    /// [`ScatteringError`] if a value is outside its range, or if polarisation is to be tracked in
    /// an ellipse.
    pub fn new(optics: FiberOptics, section: &Section) -> Result<Self, ScatteringError> {
        let scatterer = Scatterer::new(optics, FiberOutline::of(section)?)?;
        let balance = Balance::new(&scatterer, &EnergyTable::new(&scatterer));
        let round = scatterer.outline == FiberOutline::Circle;
        let offsets = round.then(|| OffsetTable::new(&scatterer, &balance));
        Ok(Self { scatterer, balance, offsets })
    }

    /// What the fibre scatters of the light that it receives under the inclination `theta`, rad,
    /// over its width and, for an ellipse, over all azimuths.
    #[must_use]
    pub fn albedo(&self, theta: f64) -> Vector3<f64> {
        self.balance.albedo(&Inclination::of(theta))
    }

    fn pair(&self, arrival: &Arrival, r: &Inclination, rays: Rays) -> ScatteringPair {
        let i = &arrival.inclination;
        let balance = self.balance.at(r);
        let scale = arrival.balance.scale.min(balance.scale);
        let lobes = SymmetricLobe::all(&self.scatterer.lobes, i, r).map(|lobe| scale * lobe);
        ScatteringPair { lobes, rays, balance }
    }

    fn rays(&self, arrival: &Arrival, cos2: f64) -> Rays {
        let cone = self.scatterer.cone(cos2);
        self.scatterer.rays(cone, &arrival.from, &arrival.offset)
    }

    /// The rays by which lobes to the inclination `r` are attenuated.
    fn rays_to(&self, arrival: &Arrival, r: &Inclination) -> Rays {
        self.rays(arrival, cos2_half_difference(&arrival.inclination, r))
    }

    /// The parts of `f`, where the change of azimuth is `change`.
    fn parts(
        &self,
        arrival: &Arrival,
        pair: &ScatteringPair,
        change: f64,
    ) -> [Vector3<f64>; LOBES] {
        let spread =
            self.scatterer.azimuthal.densities(pair.rays.azimuth.map(|of| wrapped(change - of)));
        let [x, y, z] = [0, 1, 2].map(|p| pair.rays.energy[p] * (pair.lobes[p] * spread[p]));
        let later = pair.rays.energy[3] * (pair.lobes[3] / TAU);
        [x, y, z, later, self.balance.lobe(&arrival.balance, &pair.balance)]
    }

    /// One try to draw a lobe and an inclination for a circle, if they are accepted.
    fn attempt(
        &self,
        arrival: &Arrival,
        random: &mut dyn FnMut() -> f64,
    ) -> Option<(usize, Inclination, Rays)> {
        let p = choose(&arrival.chances, random())?;
        let Some(lobe) = self.scatterer.lobes.get(p) else {
            let r = self.balance.try_draw(&arrival.balance, random)?;
            return Some((p, r, self.rays_to(arrival, &r)));
        };
        let i = &arrival.inclination;
        let r = lobe.draw(i, random);
        let scale = self.balance.at(&r).scale.min(arrival.balance.scale);
        let (kept, most) = (lobe.kept(i, &r) * scale, random());
        // Before rays are traced, whose energy is at most the bound.
        if kept < most * arrival.balance.scale {
            return None;
        }
        let rays = self.rays_to(arrival, &r);
        (rays.energy[p].mean() * kept >= most * arrival.chances[p]).then_some((p, r, rays))
    }

    /// Density of the inclination `r` among samples of an ellipse, over `cos^2 theta d theta`.
    fn density(&self, arrival: &Arrival, pair: &ScatteringPair, r: &Inclination) -> f64 {
        let proposal = |p: usize| self.scatterer.lobes[p].proposal(&arrival.inclination, r);
        let lobes = [0, 1, 2, 3].map(|p| arrival.chances[p] * proposal(p));
        lobes.iter().sum::<f64>() + arrival.chances[4] * self.balance.density(&pair.balance)
    }

    /// Chances of the lobes once both inclinations are known, not yet of sum 1.
    fn shares(&self, arrival: &Arrival, pair: &ScatteringPair) -> [f64; LOBES] {
        let last = self.balance.lobe(&arrival.balance, &pair.balance).mean() * TAU;
        let [a, b, c, d] = [0, 1, 2, 3].map(|p| pair.lobes[p] * pair.rays.energy[p].mean());
        [a, b, c, d, last]
    }

    fn scattering(
        &self,
        arrival: &Arrival,
        pair: &ScatteringPair,
        change: f64,
        r: &Inclination,
    ) -> Scattering {
        let value: Vector3<f64> = self.parts(arrival, pair, change).iter().sum();
        let density = if self.offsets.is_some() {
            arrival.albedo.recip()
        } else {
            self.density(arrival, pair, r) / self.shares(arrival, pair).iter().sum::<f64>()
        };
        // Where nothing is scattered, the density may be no number.
        let pdf = if value.mean() > 0.0 { value.mean() * r.cos * density } else { 0.0 };
        Scattering { value, pdf }.or_none()
    }
}

impl FiberBsdf for NearField {
    fn arrive(&self, offset: f64, from: &Vector3<f64>) -> Arrival {
        let mut arrival = Arrival::new(offset, from);
        let i = arrival.inclination;
        arrival.balance = self.balance.at(&i);
        let cos2 = i.cos * i.cos;
        if let Some(table) = &self.offsets {
            arrival.albedo = table.albedo(arrival.offset.h, &i);
            let bounds = table.bounds.at_offset(cos2, arrival.offset.h);
            let [a, b, c, d] = bounds.map(|bound| bound * arrival.balance.scale);
            arrival.chances = [a, b, c, d, self.balance.chance(&arrival.balance)];
        } else {
            let (rays, kept) = (self.rays(&arrival, cos2), self.balance.kept(&i));
            let [a, b, c, d] = [0, 1, 2, 3].map(|p| rays.energy[p].mean() * kept[p]);
            let chances = [a, b, c, d, self.balance.last(&arrival.balance)];
            let sum: f64 = chances.iter().sum();
            arrival.chances = chances.map(|chance| if sum > 0.0 { chance / sum } else { 0.0 });
        }
        arrival
    }

    fn lobes(&self, arrival: &Arrival, to: &Vector3<f64>) -> [Vector3<f64>; LOBES] {
        let r = inclination(to);
        let pair = self.pair(arrival, &r, self.rays_to(arrival, &r));
        self.parts(arrival, &pair, azimuth_change(&arrival.from, to))
    }

    fn evaluate(&self, arrival: &Arrival, to: &Vector3<f64>) -> Scattering {
        let r = inclination(to);
        let pair = self.pair(arrival, &r, self.rays_to(arrival, &r));
        self.scattering(arrival, &pair, azimuth_change(&arrival.from, to), &r)
    }

    /// For a circle, a lobe is drawn by its bound, then the inclination, until one is accepted with
    /// the energy that the ray has there: some two tries for fair hair, three for black.
    ///
    /// For an ellipse, the inclination is drawn from the lobes as they are attenuated at that of
    /// `from`; then, both being known, a lobe again, by which the azimuth is drawn.
    fn sample(&self, arrival: &Arrival, random: &mut dyn FnMut() -> f64) -> Option<ScatteredRay> {
        let (p, r, pair) = if self.offsets.is_some() {
            let tries = (0..MOST_TRIES).find_map(|_| self.attempt(arrival, random));
            let (p, r, rays) = tries?;
            (p, r, self.pair(arrival, &r, rays))
        } else {
            let r = match choose(&arrival.chances, random())? {
                4 => self.balance.draw(random),
                p => self.scatterer.lobes[p].draw(&arrival.inclination, random),
            };
            let pair = self.pair(arrival, &r, self.rays_to(arrival, &r));
            (choose(&self.shares(arrival, &pair), random())?, r, pair)
        };
        let change = match pair.rays.azimuth.get(p) {
            Some(of) => wrapped(of + self.scatterer.azimuthal.quantile(random())),
            None => PI * (2.0 * random() - 1.0),
        };
        let to = turned(&arrival.from, change, &r);
        self.scattering(arrival, &pair, change, &r).sampled(to, r.cos)
    }
}
