use crate::draw::MOST_TRIES;
use crate::energy::EnergyTable;
use crate::grid::{cell, nodes};
use crate::longitudinal::Inclination;
use crate::scatterer::{Scatterer, cos2_half_difference, half_tangent};
use nalgebra::Vector3;
use rapunzel_fiber::quadrature::gauss_legendre;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// What keeps the energy of all lobes together at 1.
///
/// A lobe attenuated at `theta_d` gives `integral K_p a_p(theta_d) cos^2 theta_r d theta_r`.
/// Without absorption the sum over the lobes is 1 if they have one width and no tilt, since the
/// `a_p` add to 1 at every `theta_d`; else it is `E(theta_i)`: below 1 where tilt loses energy,
/// above where R is narrower than TT. So all lobes are scaled by the smaller of `s(theta_i)` and
/// `s(theta_r)`, where `s = min(1, 1 / E)`, which is symmetric, and what is then missing,
/// `rho(theta_i)`, at least 0, is given to one more lobe, `rho(theta_i) rho(theta_r) / (2 pi
/// integral rho)`: it is symmetric too, and the sum is 1 for every `theta_i`. Light takes the color
/// of the whole fibre there, half at each end: `g = rho sqrt(albedo)`.
#[derive(Debug, Clone)]
pub(crate) struct Balance {
    nodes: Vec<BalanceNode>,
    /// Integral of `rho cos^2 theta`.
    total: f64,
    /// `1 / (2 pi total)`.
    height: f64,
    /// Sums of bounds over the cells, by which the last lobe is drawn.
    bounds: Vec<f64>,
    /// Upper bound of `g / rho`.
    most: Vector3<f64>,
    /// Integral of `g cos^2 theta`, over `total`.
    tint: Vector3<f64>,
}

#[derive(Debug, Clone, Copy)]
struct BalanceNode {
    /// `s`.
    scale: f64,
    /// Energy that the lobes lack, without absorption.
    lack: f64,
    /// `g`.
    tinted: Vector3<f64>,
    /// What the whole fibre scatters of what it receives.
    albedo: Vector3<f64>,
    /// What each lobe scatters, over what it has at this inclination, the mean of the colors.
    kept: [f64; 4],
}

/// The balance at one inclination.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct BalancePoint {
    pub(crate) scale: f64,
    pub(crate) lack: f64,
    pub(crate) tinted: Vector3<f64>,
}

impl Balance {
    pub(crate) fn new(scatterer: &Scatterer, energies: &EnergyTable) -> Self {
        const BALANCE_CELLS: u32 = 1440;
        let rule = gauss_legendre(32);
        let at: Vec<f64> = nodes(BALANCE_CELLS).map(|x| 2.0 * x - 1.0).collect();
        let sums = |scale: &(dyn Fn(&Inclination) -> f64 + Sync)| -> Vec<LobeSums> {
            let of = |t: &f64| lobes_energy(scatterer, energies, 2.0 * t.atan(), &rule, scale);
            at.par_iter().map(of).collect()
        };
        let mut scaled = sums(&|_| 1.0);
        let scales: Vec<f64> = scaled.iter().map(|sums| 1.0 / sums.clear.max(1.0)).collect();
        if scales.iter().any(|scale| *scale < 1.0) {
            scaled = sums(&|i| {
                let (k, part) = place(i, scales.len() - 1);
                scales[k] + (scales[k + 1] - scales[k]) * part
            });
        }
        let node = |((t, sums), scale): ((&f64, &LobeSums), &f64)| {
            let lack = (1.0 - sums.clear).max(0.0);
            let has = energies.at(t.abs()).absorbed;
            let whole: Vector3<f64> = has.iter().sum();
            let kept = [0, 1, 2, 3].map(|p| {
                let has = has[p].mean();
                if has > 0.0 { (sums.absorbed[p].mean() / has).clamp(1e-3, 1e3) } else { 1.0 }
            });
            let albedo = sums.absorbed.iter().sum();
            let tinted = whole.map(|a| lack * a.clamp(0.0, 1.0).sqrt());
            BalanceNode { scale: *scale, lack, tinted, albedo, kept }
        };
        let whole = energies.nodes.iter().map(|n| n.absorbed.iter().sum::<Vector3<f64>>());
        let most = whole.fold(Vector3::zeros(), |most: Vector3<f64>, whole| most.sup(&whole));
        let most = most.map(|a| a.clamp(0.0, 1.0).sqrt());
        let nodes: Vec<BalanceNode> = at.iter().zip(&scaled).zip(&scales).map(node).collect();
        let mut balance = Self {
            nodes,
            most,
            total: 0.0,
            height: 0.0,
            bounds: Vec::new(),
            tint: Vector3::zeros(),
        };
        balance.close(&at);
        balance
    }

    /// Integrals over the nodes, and the albedo with the last lobe.
    fn close(&mut self, at: &[f64]) {
        let pair = gauss_legendre(3);
        let (mut total, mut tint) = (0.0, Vector3::zeros());
        for (nodes, ends) in self.nodes.windows(2).zip(at.windows(2)) {
            for [x, weight] in &pair {
                let part = 0.5 * (1.0 + x);
                let t = ends[0] + part * (ends[1] - ends[0]);
                let measure = 0.5 * weight * (ends[1] - ends[0]) * measure(t);
                total += measure * (nodes[0].lack + part * (nodes[1].lack - nodes[0].lack));
                tint += (nodes[0].tinted + (nodes[1].tinted - nodes[0].tinted) * part) * measure;
            }
        }
        let mut sum = 0.0;
        let bound = |cell: usize| {
            sum += self.bound(cell);
            sum
        };
        self.bounds = (0..self.nodes.len() - 1).map(bound).collect();
        if total > 0.0 {
            (self.total, self.height, self.tint) = (total, 1.0 / (TAU * total), tint / total);
        }
        let tint = self.tint;
        self.nodes.iter_mut().for_each(|n| n.albedo += n.tinted.component_mul(&tint));
    }

    fn between(&self, i: &Inclination) -> (&[BalanceNode], f64) {
        let (k, part) = place(i, self.nodes.len() - 1);
        (&self.nodes[k..k + 2], part)
    }

    pub(crate) fn at(&self, i: &Inclination) -> BalancePoint {
        let (n, part) = self.between(i);
        let scale = n[0].scale + (n[1].scale - n[0].scale) * part;
        let lack = n[0].lack + (n[1].lack - n[0].lack) * part;
        BalancePoint { scale, lack, tinted: n[0].tinted + (n[1].tinted - n[0].tinted) * part }
    }

    /// What the whole fibre scatters of what it receives under an inclination.
    pub(crate) fn albedo(&self, i: &Inclination) -> Vector3<f64> {
        let (n, part) = self.between(i);
        n[0].albedo + (n[1].albedo - n[0].albedo) * part
    }

    /// What each lobe scatters under an inclination, over what it has there.
    pub(crate) fn kept(&self, i: &Inclination) -> [f64; 4] {
        let (n, part) = self.between(i);
        [0, 1, 2, 3].map(|p| n[0].kept[p] + (n[1].kept[p] - n[0].kept[p]) * part)
    }

    /// What the last lobe scatters, the mean of the colors.
    pub(crate) fn last(&self, i: &BalancePoint) -> f64 {
        i.tinted.dot(&self.tint) / 3.0
    }

    /// The last lobe, per sr.
    pub(crate) fn lobe(&self, i: &BalancePoint, r: &BalancePoint) -> Vector3<f64> {
        if self.total > 0.0 {
            i.tinted.component_mul(&r.tinted) * self.height
        } else {
            Vector3::zeros()
        }
    }

    /// Chance of a try by [`Self::try_draw`], at least what the last lobe scatters of light from
    /// `i`: the mean of the colors.
    pub(crate) fn chance(&self, i: &BalancePoint) -> f64 {
        i.tinted.dot(&self.most) / 3.0
    }

    /// An inclination drawn by the last lobe in light from `i`, unless it is refused.
    pub(crate) fn try_draw(
        &self,
        i: &BalancePoint,
        random: &mut dyn FnMut() -> f64,
    ) -> Option<Inclination> {
        let drawn = self.draw(random);
        let r = self.at(&drawn);
        let accepted = i.tinted.dot(&r.tinted) >= random() * i.tinted.dot(&self.most) * r.lack;
        accepted.then_some(drawn)
    }

    /// Density by which [`Self::draw`] draws, over `cos^2 theta d theta`.
    pub(crate) fn density(&self, r: &BalancePoint) -> f64 {
        if self.total > 0.0 { r.lack / self.total } else { 0.0 }
    }

    /// An inclination drawn by the lack of energy: a cell by its bound, then a place in it.
    pub(crate) fn draw(&self, random: &mut dyn FnMut() -> f64) -> Inclination {
        let cells = self.nodes.len() - 1;
        let whole = self.bounds.last().map_or(0.0, |last| *last);
        let mut t = 0.0;
        for _ in 0..MOST_TRIES {
            let u = whole * random();
            let cell = self.bounds.partition_point(|sum| *sum <= u).min(cells - 1);
            let part = random();
            t = 2.0 * (cell as f64 + part) / cells as f64 - 1.0;
            let lack = self.nodes[cell].lack * (1.0 - part) + self.nodes[cell + 1].lack * part;
            if random() * self.bound(cell) <= lack * measure(t) {
                break;
            }
        }
        let square = 1.0 + t * t;
        Inclination { sin: 2.0 * t / square, cos: (1.0 - t * t).max(0.0) / square }
    }

    /// Upper bound of the lack of energy times the measure in a cell.
    fn bound(&self, cell: usize) -> f64 {
        let cells = self.nodes.len() - 1;
        let end = |k: usize| 2.0 * k as f64 / cells as f64 - 1.0;
        let nearest = end(cell).max(-end(cell + 1)).max(0.0);
        self.nodes[cell].lack.max(self.nodes[cell + 1].lack) * measure(nearest)
    }
}

/// `cos^2 theta d theta / dt`, where `t` is `tan(theta / 2)`.
fn measure(t: f64) -> f64 {
    let square = 1.0 + t * t;
    2.0 * (1.0 - t * t) * (1.0 - t * t) / (square * square * square)
}

/// The cell of the nodes where an inclination lies, and where in it.
pub(crate) fn place(i: &Inclination, cells: usize) -> (usize, f64) {
    cell(0.5 + 0.5 * i.sin / (1.0 + i.cos), cells)
}

/// What lobes scatter: all together without absorption, each with it.
#[derive(Default)]
struct LobeSums {
    clear: f64,
    absorbed: [Vector3<f64>; 4],
}

fn lobes_energy(
    scatterer: &Scatterer,
    energies: &EnergyTable,
    theta_i: f64,
    rule: &[[f64; 2]],
    scale: &dyn Fn(&Inclination) -> f64,
) -> LobeSums {
    let i = Inclination::of(theta_i);
    let (mut sums, own) = (LobeSums::default(), scale(&i));
    scatterer.over_ends(theta_i, rule, |p, r, measure| {
        let energy = energies.at(half_tangent(cos2_half_difference(&i, r)));
        let measure = measure * own.min(scale(r));
        sums.clear += energy.clear[p] * measure;
        sums.absorbed[p] += energy.absorbed[p] * measure;
    });
    sums
}
