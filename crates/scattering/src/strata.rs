use crate::circle::CirclePaths;
use crate::grid::{cell, nodes};
use crate::scatterer::{Scatterer, half_tangent};
use crate::{FresnelReflectance, Polarization};

/// Strata of the offset, `|h|` in even parts of `[0, 1]`.
pub(crate) const STRATA: usize = 16;

/// Upper bounds of what leaves in each order and stratum of a round fibre, for all inclinations at
/// which a lobe from one inclination can be attenuated: with them samples are drawn exactly, by
/// rejection.
#[derive(Debug, Clone)]
pub(crate) struct StratumBounds {
    rows: Vec<[[f64; STRATA]; 4]>,
}

impl StratumBounds {
    pub(crate) fn new(scatterer: &Scatterer) -> Self {
        const STRATUM_CELLS: u32 = 64;
        let row = |t: f64| {
            // |theta_d| is at most 45 degrees and half of the inclination.
            let sin = 2.0 * t / (1.0 + t * t);
            let steepest = CirclePaths::of(scatterer.cone(0.5 * (1.0 - sin)));
            let level = CirclePaths::of(scatterer.cone(1.0));
            let mut row = [[0.0; STRATA]; 4];
            for k in 0..STRATA {
                let [low, high] = [k, k + 1].map(|k| k as f64 / STRATA as f64);
                let bounds = bounds(scatterer, &level, &steepest, low, high);
                (0..4).for_each(|p| row[p][k] = bounds[p]);
            }
            row
        };
        Self { rows: nodes(STRATUM_CELLS).map(row).collect() }
    }

    /// The bounds for light from an inclination of the squared cosine `cos2`.
    pub(crate) fn at(&self, cos2: f64) -> &[[f64; STRATA]; 4] {
        // Bounds rise with the inclination: those of the node above hold in the cell.
        &self.rows[cell(half_tangent(cos2), self.rows.len() - 1).0 + 1]
    }

    /// The bounds of the stratum of one offset.
    pub(crate) fn at_offset(&self, cos2: f64, h: f64) -> [f64; 4] {
        let (stratum, _) = cell(h.abs(), STRATA);
        self.at(cos2).map(|strata| strata[stratum])
    }
}

/// Reflectance rises with the offset and the inclination, that in the plane of incidence of an
/// index beyond `2 + sqrt 3` so late that the mean falls at first; the path inside rises with the
/// inclination, but falls with the offset.
fn bounds(
    scatterer: &Scatterer,
    level: &CirclePaths,
    steepest: &CirclePaths,
    low: f64,
    high: f64,
) -> [f64; 4] {
    let fresnel = |paths: &CirclePaths, h: f64| {
        let ([i, t], cone) = (paths.cosines(h), paths.cone());
        FresnelReflectance::new(cone.n, cone.cos * i, cone.cos_inside() * t)
    };
    let (first, mut most) = (fresnel(level, low), fresnel(steepest, high));
    let mut least = first.mean();
    if scatterer.optics.refractive_index > 2.0 + 3.0_f64.sqrt() {
        (least, most.p) = (0.5 * first.s, most.p.max(first.p));
    }
    let sigma = &scatterer.optics.absorption;
    let t = sigma.map(|s| (-s * level.segment(high)).exp());
    let passed = |p: i32| t.map(|t| t.powi(p)).mean();
    let enters = 1.0 - least;
    let [tt, trt, later] = match scatterer.optics.polarization {
        Polarization::Averaged => {
            // The largest value of f on [least, most], where it rises up to `peak`.
            let top = |f: &dyn Fn(f64) -> f64, peak: f64| f(peak.clamp(least, most.mean()));
            let trt = top(&|f| (1.0 - f) * (1.0 - f) * f, 1.0 / 3.0);
            [enters * enters, trt, top(&|f| (1.0 - f) * f * f, 2.0 / 3.0)]
        }
        // What is inside stays there at most as if it were all polarised across.
        Polarization::Tracked => [enters, enters * most.s, enters * most.s * most.s],
    };
    // A hair's breadth for rounding.
    [most.mean(), tt * passed(1), trt * passed(2), later * passed(3)].map(|b| b * (1.0 + 1e-9))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FiberOptics;
    use crate::scatterer::{FiberOutline, Offset};
    use nalgebra::Vector3;

    #[test]
    fn nothing_exceeds_its_bound() {
        for (polarization, refractive_index) in [
            (Polarization::Averaged, 1.55),
            (Polarization::Tracked, 1.55),
            (Polarization::Averaged, 8.0),
        ] {
            let sigma = Vector3::new(0.1, 0.4, 2.0);
            let optics = FiberOptics::hair(sigma, 0.3, 0.3, 0.05).expect("hair");
            let optics = FiberOptics { polarization, refractive_index, ..optics };
            let scatterer = Scatterer::new(optics, FiberOutline::Circle).expect("hair");
            let bounds = StratumBounds::new(&scatterer);
            for k in 0..90_u32 {
                let theta = f64::from(k).to_radians();
                let bounds = bounds.at(theta.cos().powi(2));
                for step in 0..90_u32 {
                    let d = f64::from(step) / 89.0 * (0.5 * theta + 0.25 * std::f64::consts::PI);
                    for stratum in 0..STRATA {
                        let h = Offset::of((stratum as f64 + 0.5) / STRATA as f64);
                        let rays =
                            scatterer.rays(scatterer.cone(d.cos().powi(2)), &Vector3::x(), &h);
                        for p in 0..4 {
                            assert!(rays.energy[p].mean() <= bounds[p][stratum], "{p} {h:?} {d}");
                        }
                    }
                }
            }
        }
    }
}
