use crate::grid::{cell, count, nodes};
use crate::scatterer::{FiberOutline, Scatterer};
use nalgebra::Vector3;
use rapunzel_fiber::quadrature::gauss_legendre;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// What leaves in R, TT, TRT and later orders over the whole width of a fibre, by the inclination:
/// linear between nodes in `tan(|theta| / 2)`, with the absorption and without it.
#[derive(Debug, Clone)]
pub(crate) struct EnergyTable {
    pub(crate) half_tangents: Vec<f64>,
    pub(crate) nodes: Vec<LobeEnergies>,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct LobeEnergies {
    pub(crate) absorbed: [Vector3<f64>; 4],
    /// Without absorption; they add to 1.
    pub(crate) clear: [f64; 4],
}

impl EnergyTable {
    /// The table of a fibre: for a circle with the nodes that the azimuths of the far field need,
    /// so that both fields keep the same balance.
    pub(crate) fn new(scatterer: &Scatterer) -> Self {
        let cells = match scatterer.outline {
            // A caustic moves up to three times as fast as theta_d; near grazing the grid is finer.
            FiberOutline::Circle => count(20.0 / scatterer.optics.azimuthal_scale, 128.0, 1024.0),
            FiberOutline::Ellipse(_) => 256,
        };
        let samples = samples(&scatterer.outline);
        let at: Vec<f64> = nodes(cells).collect();
        let of = |t: &f64| mean(scatterer, *t, &samples);
        Self { nodes: at.par_iter().map(of).collect(), half_tangents: at }
    }

    /// What leaves in later orders at `tan(|theta| / 2)`.
    pub(crate) fn later(&self, half_tangent: f64) -> Vector3<f64> {
        let (k, part) = cell(half_tangent, self.nodes.len() - 1);
        let [a, b] = [k, k + 1].map(|k| &self.nodes[k].absorbed[3]);
        a + (b - a) * part
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

/// Azimuths and offsets over which energies are averaged, with their weights, of sum 1.
fn samples(outline: &FiberOutline) -> Vec<[f64; 3]> {
    let at = |phi: f64, x: f64, weight: f64| {
        [phi, (FRAC_PI_2 * x).sin(), weight * (FRAC_PI_2 * x).cos()]
    };
    let raw: Vec<[f64; 3]> = match outline {
        // In gamma all is smooth.
        FiberOutline::Circle => gauss_legendre(64).iter().map(|[x, w]| at(0.0, *x, *w)).collect(),
        // A lattice of Fibonacci over half a turn: total reflection makes edges.
        FiberOutline::Ellipse(_) => {
            let even = |k: u32, step: u32| f64::from(k * step % 2584) / 2584.0;
            (0..2584).map(|k| at(PI * even(k, 1), 2.0 * even(k, 1597) - 1.0, 1.0)).collect()
        }
    };
    let sum: f64 = raw.iter().map(|[_, _, weight]| weight).sum();
    raw.into_iter().map(|[phi, h, weight]| [phi, h, weight / sum]).collect()
}

/// The mean over the width.
fn mean(scatterer: &Scatterer, t: f64, samples: &[[f64; 3]]) -> LobeEnergies {
    let cos = (1.0 - t * t) / (1.0 + t * t);
    let cone = scatterer.cone(cos * cos);
    let mut sum = LobeEnergies { absorbed: [Vector3::zeros(); 4], clear: [0.0; 4] };
    for [phi, h, weight] in samples {
        let [absorbed, clear] = scatterer.energies(cone, *phi, *h);
        for p in 0..4 {
            sum.absorbed[p] += absorbed[p] * *weight;
            sum.clear[p] += clear[p].x * weight;
        }
    }
    sum
}
