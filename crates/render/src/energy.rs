use crate::quadrature::{cell, gauss_legendre, nodes};
use crate::scatterer::{Profile, Scatterer};
use nalgebra::Vector3;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// What leaves in R, TT, TRT and later orders over the whole width of a fibre, by the inclination:
/// linear between nodes in `tan(|theta| / 2)`, with the absorption and without it.
#[derive(Debug, Clone)]
pub(crate) struct EnergyTable {
    pub(crate) nodes: Vec<LobeEnergies>,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct LobeEnergies {
    pub(crate) absorbed: [Vector3<f64>; 4],
    /// Without absorption; they add to 1.
    pub(crate) clear: [f64; 4],
}

impl EnergyTable {
    /// The table with `cells` cells.
    pub(crate) fn new(scatterer: &Scatterer, cells: u32) -> Self {
        let rule = gauss_legendre(64);
        let at: Vec<f64> = nodes(cells).collect();
        let of = |t: &f64| mean(scatterer, *t, &rule);
        Self { nodes: at.par_iter().map(of).collect() }
    }

    /// The energies at `tan(|theta| / 2)`.
    pub(crate) fn at(&self, half_tangent: f64) -> LobeEnergies {
        let (k, part) = cell(half_tangent, self.nodes.len() - 1);
        let (a, b) = (&self.nodes[k], &self.nodes[k + 1]);
        let mut at = *a;
        for p in 0..4 {
            at.absorbed[p] += (b.absorbed[p] - a.absorbed[p]) * part;
            at.clear[p] += (b.clear[p] - a.clear[p]) * part;
        }
        at
    }
}

/// The mean over the width: over `h = sin gamma` by the rule of Gauss in gamma, in which all is smooth
/// but total reflection in an ellipse; over half a turn of an ellipse.
fn mean(scatterer: &Scatterer, t: f64, rule: &[[f64; 2]]) -> LobeEnergies {
    const TURNS: u32 = 24;
    let cos = (1.0 - t * t) / (1.0 + t * t);
    let cone = scatterer.cone(cos * cos);
    let turns = if scatterer.profile == Profile::Circle { 1 } else { TURNS };
    let mut sum = LobeEnergies { absorbed: [Vector3::zeros(); 4], clear: [0.0; 4] };
    let mut all = 0.0;
    for turn in 0..turns {
        let phi = (f64::from(turn) + 0.5) / f64::from(turns) * PI;
        for [x, weight] in rule {
            let (h, width) = (FRAC_PI_2 * x).sin_cos();
            let [absorbed, clear] = scatterer.energies(cone, phi, h);
            for p in 0..4 {
                sum.absorbed[p] += absorbed[p] * (weight * width);
                sum.clear[p] += clear[p].x * (weight * width);
            }
            all += weight * width;
        }
    }
    LobeEnergies { absorbed: sum.absorbed.map(|e| e / all), clear: sum.clear.map(|e| e / all) }
}
