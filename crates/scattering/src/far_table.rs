use crate::circle::CirclePaths;
use crate::energy::EnergyTable;
use crate::grid::{cell, count};
use crate::scatterer::{Offset, Scatterer};
use nalgebra::Vector3;
use rapunzel_fiber::quadrature::gauss_legendre;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// The normal scattering `N_p(theta_d, dphi)` of R, TT and TRT with a finite azimuthal width, over
/// the whole width of a round fibre: `1/2 integral A T l(dphi - dphi_p(h)) dh`, where `l` is the
/// logistic distribution. This is (6.11) of the thesis, folded; its caustics keep their energy with
/// no special case. Bilinear between nodes whose distance is a ninth of the width or less.
#[derive(Debug, Clone)]
pub(crate) struct FarTable {
    pub(crate) energies: EnergyTable,
    azimuths: usize,
    /// Rows of `azimuths + 1` nodes over `[0, pi]`, one for each node of the energies.
    nodes: Vec<NormalScattering>,
}

/// Normal scattering, per rad: R has no color.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct NormalScattering {
    pub(crate) r: f64,
    pub(crate) tt: Vector3<f64>,
    pub(crate) trt: Vector3<f64>,
}

impl FarTable {
    /// The table of a round fibre. Its size grows as one over the square of the azimuthal width, up
    /// to 83 MB at 0.02 rad; below, it is coarser than is said above.
    pub(crate) fn new(scatterer: &Scatterer) -> Self {
        let scale = scatterer.optics.azimuthal_scale;
        let azimuths = count(9.0 * PI / scale, 64.0, 1440.0);
        let energies = EnergyTable::new(scatterer);
        let rule = gauss_legendre(32 + count(2.5 * PI / scale, 0.0, 400.0) as usize);
        let row = |(k, t): (usize, &f64)| {
            let mut row = row(scatterer, *t, azimuths, &rule);
            normalize(&mut row, &energies.nodes[k].absorbed);
            row
        };
        let nodes = energies.half_tangents.par_iter().enumerate().flat_map_iter(row).collect();
        Self { energies, azimuths: azimuths as usize, nodes }
    }

    /// The normal scattering at `tan(|theta_d| / 2)` and the change of azimuth `change`, rad, in
    /// `[-pi, pi]`.
    pub(crate) fn at(&self, half_tangent: f64, change: f64) -> NormalScattering {
        let (i, u) = cell(half_tangent, self.energies.nodes.len() - 1);
        let (j, v) = cell(change.abs() / PI, self.azimuths);
        let row = self.azimuths + 1;
        let mut sum = NormalScattering::default();
        for (k, weight) in [
            (i * row + j, (1.0 - u) * (1.0 - v)),
            (i * row + j + 1, (1.0 - u) * v),
            ((i + 1) * row + j, u * (1.0 - v)),
            ((i + 1) * row + j + 1, u * v),
        ] {
            let node = &self.nodes[k];
            sum.r += weight * node.r;
            sum.tt += node.tt * weight;
            sum.trt += node.trt * weight;
        }
        sum
    }
}

/// One row: every ray is spread over the azimuths.
fn row(scatterer: &Scatterer, t: f64, azimuths: u32, rule: &[[f64; 2]]) -> Vec<NormalScattering> {
    let cos = (1.0 - t * t) / (1.0 + t * t);
    let cone = scatterer.cone(cos * cos);
    let paths = CirclePaths::of(cone);
    let mut row = vec![NormalScattering::default(); azimuths as usize + 1];
    for [x, weight] in rule {
        let (h, width) = (0.5 * FRAC_PI_2 * (1.0 + x)).sin_cos();
        // The rays at h and -h are mirror images; half of 1/2 dh each.
        let share = 0.5 * weight * width * 0.5 * FRAC_PI_2;
        let [r, tt, trt, _] =
            scatterer.rays(cone, &Vector3::x(), &Offset::of(h)).energy.map(|e| e * share);
        for (p, azimuth) in paths.azimuths(h).into_iter().enumerate() {
            let add = |node: &mut NormalScattering, density: f64| match p {
                0 => node.r += density * r.x,
                1 => node.tt += tt * density,
                _ => node.trt += trt * density,
            };
            spread(&mut row, azimuth, scatterer.optics.azimuthal_scale, &add);
            spread(&mut row, -azimuth, scatterer.optics.azimuthal_scale, &add);
        }
    }
    row
}

/// Adds the logistic distribution around `center` to all nodes, but for its factor: its
/// exponentials are a geometric sequence over the nodes.
fn spread(
    row: &mut [NormalScattering],
    center: f64,
    scale: f64,
    add: &impl Fn(&mut NormalScattering, f64),
) {
    let center = crate::circle::wrapped(center);
    let step = PI / (row.len() - 1) as f64;
    let ratio = (-step / scale).exp();
    // Nodes nearer to the same angle one turn on, where the center is negative.
    #[expect(clippy::cast_possible_truncation, reason = "in the row")]
    let index = |angle: f64| ((angle / step).ceil().max(0.0) as usize).min(row.len());
    let (first, turn) = (index(center), index(center + PI));
    let sweep = |nodes: &mut dyn Iterator<Item = (usize, &mut NormalScattering)>, center: f64| {
        let mut e = None;
        for (k, node) in nodes {
            let now = e.unwrap_or_else(|| (-(k as f64 * step - center).abs() / scale).exp());
            add(node, now / ((1.0 + now) * (1.0 + now)));
            e = Some(now * ratio);
        }
    };
    let (near, far) = row.split_at_mut(turn);
    let (below, above) = near.split_at_mut(first.min(turn));
    sweep(&mut above.iter_mut().enumerate().map(|(k, n)| (k + first, n)), center);
    sweep(&mut below.iter_mut().enumerate().rev(), center);
    sweep(&mut far.iter_mut().enumerate().map(|(k, n)| (k + turn, n)).rev(), center + TAU);
}

/// Scales a row to the energies of its lobes, over both sides by the trapezoidal rule, as which the
/// interpolation integrates.
fn normalize(row: &mut [NormalScattering], energy: &[Vector3<f64>; 4]) {
    let step = PI / (row.len() - 1) as f64;
    let mut sum = NormalScattering::default();
    let last = row.len() - 1;
    for (k, node) in row.iter().enumerate() {
        let weight = if k == 0 || k == last { step } else { 2.0 * step };
        sum.r += weight * node.r;
        sum.tt += node.tt * weight;
        sum.trt += node.trt * weight;
    }
    let factor = |energy: f64, sum: f64| if sum > 0.0 { energy / sum } else { 0.0 };
    let r = factor(energy[0].x, sum.r);
    let tt = energy[1].zip_map(&sum.tt, factor);
    let trt = energy[2].zip_map(&sum.trt, factor);
    for node in row {
        node.r *= r;
        node.tt.component_mul_assign(&tt);
        node.trt.component_mul_assign(&trt);
    }
}
