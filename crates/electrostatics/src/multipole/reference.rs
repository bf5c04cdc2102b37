//! What the certificate is made of.

use super::near::Cloud;
use crate::method::direct_sums;

/// The direct sums at some of the targets.
pub(super) struct Reference {
    pub(super) samples: Vec<usize>,
    /// For how many targets each sample stands.
    weights: Vec<f64>,
    sums: Vec<[f64; 4]>,
}

impl Reference {
    /// Takes samples all over the targets at `places`, given about the squares of their fields. A third of
    /// them is uniform, a third as frequent as the field is strong and a third as its square, because few
    /// targets may hold most of the sum of squares.
    pub(super) fn new(cloud: &Cloud, places: &[Vec<f64>; 3], strengths: &[f64]) -> Self {
        let targets = strengths.len();
        let wanted = (100_000_000 / cloud.len().max(1)).clamp(64, 2048).min(targets);
        let totals = strengths.iter().fold([0.0; 2], |[a, b], s| [a + s, b + s.sqrt()]);
        let share = |part: f64, total: f64| if total > 0.0 { part / total } else { 0.0 };
        let (mut samples, mut weights) = (Vec::new(), Vec::new());
        let (mut picks, mut passed) = (0, 0.0);
        // The golden ratio spreads the places within equal parts evenly.
        let place = |k: usize| (k as f64 + (k as f64 * 0.618_033_988_75).fract()) / wanted as f64;
        for (target, &strength) in strengths.iter().enumerate() {
            let strong = share(strength, totals[0]) + share(strength.sqrt(), totals[1]);
            let chance = (1.0 / targets as f64 + strong) / 3.0;
            passed += chance;
            let before = picks;
            while picks < wanted && place(picks) < passed {
                picks += 1;
            }
            if picks > before {
                samples.push(target);
                weights.push((picks - before) as f64 / (chance * wanted as f64));
            }
        }
        let places = [0, 1, 2].map(|d| samples.iter().map(|&k| places[d][k]).collect());
        let sums = direct_sums(cloud, 0.0, &places);
        Self { samples, weights, sums }
    }

    /// The relative error of the gradients.
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
