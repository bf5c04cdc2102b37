//! What the certificate is made of.

use super::tree::{Cell, Octree};
use crate::direct_sum::{Cloud, direct_sums};
use rayon::prelude::*;

/// Number of targets that are looked at one by one if there is a sample among them.
const TARGETS_PER_PART: usize = 256;

/// Direct sums at some of the targets.
pub(super) struct Reference {
    /// Indices of the sampled targets, ascending.
    pub(super) samples: Vec<usize>,
    /// Number of targets that each sample stands for.
    weights: Vec<f64>,
    /// Potential and its gradient at each sample.
    sums: Vec<[f64; 4]>,
}

/// Number of samples wanted among `targets` for sums over `sources`: more where they cost little.
pub(super) fn wanted(sources: usize, targets: usize) -> usize {
    (100_000_000 / sources.max(1)).clamp(64, 2048).min(targets)
}

/// Targets that are farthest from the center of one of the cells of their tree, ascending.
fn rims(tree: &Octree, places: &[Vec<f64>; 3]) -> Vec<usize> {
    let farthest = |cell: &Cell| {
        let squared =
            |i: usize| (0..3).map(|d| (places[d][i] - cell.center[d]).powi(2)).sum::<f64>();
        cell.bodies.clone().max_by(|&i, &j| squared(i).total_cmp(&squared(j)))
    };
    let mut rims: Vec<_> = tree.cells.iter().filter_map(farthest).collect();
    rims.sort_unstable();
    rims.dedup();
    rims
}

impl Reference {
    /// Reference at samples all over the targets of a `tree` at `places`, given about the squares
    /// of their fields as `strengths`. A third of them is uniform, a third as frequent as the field
    /// is strong and a third as its square, because few targets may hold most of the sum of
    /// squares. Beside them are the targets at the rims of cells, where they are not many: there
    /// expansions err most, in a small cloud by more than at all other targets together.
    pub(super) fn new(
        cloud: &Cloud,
        places: &[Vec<f64>; 3],
        strengths: &[f64],
        tree: &Octree,
    ) -> Self {
        let targets = strengths.len();
        let wanted = wanted(cloud.len(), targets);
        let rims = if 4 * tree.cells.len() <= wanted { rims(tree, places) } else { Vec::new() };
        let totals = |part: &[f64]| part.iter().fold([0.0; 2], |[a, b], s| [a + s, b + s.sqrt()]);
        let parts: Vec<_> = strengths.par_chunks(TARGETS_PER_PART).map(totals).collect();
        let all = parts.iter().fold([0.0; 2], |[a, b], part| [a + part[0], b + part[1]]);
        let share = |part: f64, total: f64| if total > 0.0 { part / total } else { 0.0 };
        let chance = |count: usize, [a, b]: [f64; 2]| {
            (count as f64 / targets as f64 + share(a, all[0]) + share(b, all[1])) / 3.0
        };
        let mut sampled: Vec<_> = rims.iter().map(|&rim| (rim, 1.0)).collect();
        let (mut picks, mut end) = (0, 0.0);
        // The golden ratio spreads the places within equal parts evenly.
        let place = |k: usize| (k as f64 + (k as f64 * 0.618_033_988_75).fract()) / wanted as f64;
        // Targets are passed in their order, each as long as its chance; a sample is taken wherever
        // a place of the golden sequence is passed, and weighs the inverse of its chance.
        for (k, (part, totals)) in strengths.chunks(TARGETS_PER_PART).zip(parts).enumerate() {
            let mut passed = end;
            end += chance(part.len(), totals);
            if place(picks) >= end {
                continue;
            }
            for (i, strength) in part.iter().enumerate() {
                let chance = chance(1, [*strength, strength.sqrt()]);
                passed += chance;
                let before = picks;
                while picks < wanted && place(picks) < passed {
                    picks += 1;
                }
                let target = k * TARGETS_PER_PART + i;
                if picks > before && rims.binary_search(&target).is_err() {
                    sampled.push((target, (picks - before) as f64 / (chance * wanted as f64)));
                }
            }
        }
        sampled.sort_unstable_by_key(|(target, _)| *target);
        let (samples, weights): (Vec<usize>, Vec<f64>) = sampled.into_iter().unzip();
        let places = [0, 1, 2].map(|d| samples.iter().map(|&k| places[d][k]).collect());
        let sums = direct_sums(cloud, 0.0, &places);
        Self { samples, weights, sums }
    }

    /// Relative error of the gradients `out` of all targets, by the weighted samples.
    pub(super) fn error(&self, out: &[[f64; 4]]) -> f64 {
        let [mut errors, mut squares] = [0.0; 2];
        for ((sample, weight), exact) in self.samples.iter().zip(&self.weights).zip(&self.sums) {
            for c in 1..4 {
                errors += weight * (out[*sample][c] - exact[c]).powi(2);
                squares += weight * exact[c].powi(2);
            }
        }
        if errors > 0.0 { (errors / squares).sqrt() } else { 0.0 }
    }
}
