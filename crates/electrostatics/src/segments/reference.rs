//! Forces on sampled segments, without expansions.

use super::columns::SegmentColumns;
use super::lines::{Loads, SegmentLines};
use super::near::add_close;
use super::parallel::Parallel;
use super::rules::Rules;
use crate::Accuracy;
use crate::multipole::downward::Task;
use rapunzel_lanes::Ways;
use rayon::prelude::*;

/// Number of sources whose action on the samples is found at once.
const SEGMENTS_PER_TILE: usize = 2048;

/// Error of rules over the tolerance; where segments follow each other they err by ten times as
/// much.
const REFERENCE_RULE_SHARE: f64 = 0.003;

/// Error below which rules are not made stricter.
pub(super) const STRICTEST: f64 = 1e-14;

/// Tolerance from which on single precision is enough here: a tile is at most some thousand
/// segments long, so the distance of two that a rule serves is right to 1e-4 at worst.
const COARSE_REFERENCE: f64 = 5e-4;

/// Loads of `samples` by all segments, by stricter rules than `accuracy` needs.
pub(super) fn exact(lines: &SegmentLines, accuracy: Accuracy, samples: &[usize]) -> Vec<Loads> {
    match accuracy {
        Accuracy::Tolerance(tolerance) if tolerance >= COARSE_REFERENCE => {
            exact_in::<f32>(lines, accuracy, samples)
        }
        _ => exact_in::<f64>(lines, accuracy, samples),
    }
}

/// Loads of `samples` by all segments, in the precision of `E`.
fn exact_in<E: Ways>(lines: &SegmentLines, accuracy: Accuracy, samples: &[usize]) -> Vec<Loads> {
    let error = match accuracy {
        Accuracy::Tolerance(tolerance) => (REFERENCE_RULE_SHARE * tolerance).max(STRICTEST),
        Accuracy::Order(_) => 1e-8,
    };
    let (rules, parallel) = (Rules::<E>::everywhere(error), Parallel::new(error));
    let act = |first: usize| {
        let mut out = vec![[0.0; 7]; samples.len()];
        let tile = first..lines.count().min(first + SEGMENTS_PER_TILE);
        let center = [0, 1, 2].map(|d| lines.bars[d][first]);
        let mut columns = SegmentColumns::new(lines, center, [&[tile], &[]]);
        let close = columns.act(lines, &rules, samples, &mut out);
        (out, close)
    };
    let tiles: Vec<_> = (0..lines.count()).step_by(SEGMENTS_PER_TILE).collect();
    let tiles: Vec<_> = tiles.into_par_iter().map(act).collect();
    let mut out = vec![[0.0; 7]; samples.len()];
    let mut pairs = Vec::new();
    for (loads, close) in tiles {
        out.as_flattened_mut().iter_mut().zip(loads.as_flattened()).for_each(|(x, y)| *x += y);
        pairs.extend(close);
    }
    for (&i, out) in samples.iter().zip(&mut out) {
        lines.add_self(i, out);
        let own: Vec<_> = pairs.iter().copied().filter(|pair| pair[0] == i).collect();
        let (bodies, out) = (i..i + 1, std::slice::from_mut(out));
        add_close(lines, &own, &parallel, Task { bodies, samples: Some(samples), out });
    }
    out
}
