use crate::balance::{Balance, place};
use crate::grid::{cell, nodes};
use crate::longitudinal::Inclination;
use crate::scatterer::{Offset, Scatterer, cos2_half_difference, half_tangent};
use crate::strata::StratumBounds;
use nalgebra::Vector3;
use rapunzel_fiber::quadrature::gauss_legendre;
use rayon::prelude::*;

/// What a round fibre scatters under one inclination at one offset, and bounds of the energies of
/// its lobes: the mean of the colors, linear between nodes.
#[derive(Debug, Clone)]
pub(crate) struct OffsetTable {
    /// Rows by the inclination of columns by the offset.
    albedos: Vec<f64>,
    pub(crate) bounds: StratumBounds,
}

const INCLINATIONS: u32 = 720;
const OFFSETS: u32 = 160;
/// Of `theta_d`.
const DIFFERENCES: u32 = 384;

impl OffsetTable {
    /// The table of a fibre whose lobes are balanced so.
    pub(crate) fn new(scatterer: &Scatterer, balance: &Balance) -> Self {
        // Even in the tangent of half the angle of incidence: all is smooth in that.
        let offsets: Vec<Offset> =
            nodes(OFFSETS).map(|s| Offset::of(2.0 * s / (1.0 + s * s))).collect();
        // A list for each lobe, over which sums are quick.
        let energies = |t: f64| {
            let cos = (1.0 - t * t) / (1.0 + t * t);
            let cone = scatterer.cone(cos * cos);
            let rays = offsets.iter().map(|h| scatterer.rays(cone, &Vector3::x(), h).energy);
            let means: Vec<_> = rays.map(|energy| energy.map(|e| e.mean())).collect();
            [0, 1, 2, 3].map(|p| means.iter().map(|mean| mean[p]).collect())
        };
        let energies: Vec<[Vec<f64>; 4]> = nodes(DIFFERENCES).map(energies).collect();
        let rule = gauss_legendre(32);
        let at: Vec<f64> = nodes(INCLINATIONS).map(|x| 2.0 * (2.0 * x - 1.0).atan()).collect();
        let row = |theta: &f64| row(scatterer, balance, &energies, *theta, &rule);
        let albedos = at.par_iter().flat_map_iter(row).collect();
        Self { albedos, bounds: StratumBounds::new(scatterer) }
    }

    /// What is scattered at the offset `h` of what comes from the inclination `i`.
    pub(crate) fn albedo(&self, h: f64, i: &Inclination) -> f64 {
        let (k, u) = place(i, INCLINATIONS as usize);
        let (j, v) = cell(h.abs() / (1.0 + (1.0 - h * h).max(0.0).sqrt()), OFFSETS as usize);
        let row = |k: usize| {
            let at = k * (OFFSETS as usize + 1) + j;
            self.albedos[at] + (self.albedos[at + 1] - self.albedos[at]) * v
        };
        row(k) + (row(k + 1) - row(k)) * u
    }
}

/// What is scattered at each offset of what comes from `theta`, rad.
fn row(
    scatterer: &Scatterer,
    balance: &Balance,
    energies: &[[Vec<f64>; 4]],
    theta: f64,
    rule: &[[f64; 2]],
) -> Vec<f64> {
    let i = Inclination::of(theta);
    let own = balance.at(&i);
    let mut sums = vec![balance.last(&own); OFFSETS as usize + 1];
    scatterer.over_ends(theta, rule, |p, r, measure| {
        let measure = measure * own.scale.min(balance.at(r).scale);
        let at = half_tangent(cos2_half_difference(&i, r));
        let (k, part) = cell(at, DIFFERENCES as usize);
        let (a, b) = (measure * (1.0 - part), measure * part);
        let ends = energies[k][p].iter().zip(&energies[k + 1][p]);
        sums.iter_mut().zip(ends).for_each(|(sum, (x, y))| *sum += a * x + b * y);
    });
    sums
}
