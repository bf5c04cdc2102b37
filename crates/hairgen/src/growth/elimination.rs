//! Removal of the most crowded of many points.

use super::neighbors::Neighbors;
use nalgebra::Point3;
use rayon::prelude::*;

/// Points that are less crowded than this are all alike.
const LEAST_CROWD: f64 = 1e-9;

/// Bits of a double below those that tell levels of crowds apart: there are 64 to a factor of 2.
const LEVEL_SHIFT: u32 = 46;

/// Points of a surface of the given area, m^2, are removed one by one, the most crowded first,
/// until `keep` are left (C. Yuksel, Sample elimination for generating Poisson disk sample sets,
/// Computer Graphics Forum 34, 2015). Returned are the removed ones in their order, as indices.
///
/// How crowded a point is, is the sum over its neighbors of `(1 - d / 2 r)^8`, with `r` half the
/// largest distance that `keep` points can all have from each other, and distances `d` that are
/// taken no less than a bound, so that near pairs do not count for more than crowds. Points whose
/// sums differ by less than about a hundredth are taken in any order, so that no heap is needed.
/// Cost: a sort by place and the number of pairs.
pub(super) fn eliminate(points: &[Point3<f64>], keep: usize, area: f64) -> Vec<u32> {
    // A hexagonal lattice of `keep` points, and what of it can be hoped for.
    let diameter = 2.0 * (area / (2.0 * 3.0_f64.sqrt() * keep as f64)).sqrt();
    let share = keep as f64 / points.len() as f64;
    let least = diameter * 0.65 * (1.0 - share.powf(1.5));
    let neighbors = Neighbors::within(points, diameter);
    let weight = |i: u32, j: u32| {
        let distance = (points[i as usize] - points[j as usize]).norm();
        (1.0 - distance.max(least) / diameter).max(0.0).powi(8)
    };
    let crowd = |i: usize| {
        let i = u32::try_from(i).unwrap_or(u32::MAX);
        neighbors.of(i).iter().map(|&j| weight(i, j)).sum()
    };
    let mut crowds: Vec<f64> = (0..points.len()).into_par_iter().map(crowd).collect();
    // Every point is in one level, that of its sum now or before; sums only fall.
    let highest = crowds.iter().map(|&crowd| level(crowd)).max().unwrap_or(0);
    let mut levels = vec![Vec::new(); highest + 1];
    for (point, &crowd) in (0_u32..).zip(&crowds) {
        levels[level(crowd)].push(point);
    }
    let mut removed = Vec::with_capacity(points.len() - keep);
    while removed.len() + keep < points.len() {
        let Some(top) = levels.last_mut() else { break };
        let Some(point) = top.pop() else {
            levels.pop();
            continue;
        };
        let now = level(crowds[point as usize]);
        if now + 1 < levels.len() {
            levels[now].push(point);
            continue;
        }
        removed.push(point);
        for &j in neighbors.of(point) {
            crowds[j as usize] -= weight(point, j);
        }
    }
    removed
}

/// The level of a crowd: its logarithm in steps of about a hundredth.
fn level(crowd: f64) -> usize {
    let level = |x: f64| x.to_bits() >> LEVEL_SHIFT;
    // Rounding may have made it negative.
    usize::try_from(level(1.0 + (crowd / LEAST_CROWD).max(0.0)) - level(1.0)).unwrap_or(0)
}
