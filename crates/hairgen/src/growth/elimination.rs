//! Removal of the most crowded of many points.

use super::neighbors::Neighbors;
use nalgebra::Point3;
use std::collections::BinaryHeap;

/// Points of a surface of the given area, m^2, are removed one by one, the most crowded first,
/// until `keep` are left (C. Yuksel, Sample elimination for generating Poisson disk sample sets,
/// Computer Graphics Forum 34, 2015). Returned are the removed ones in their order, as indices.
///
/// How crowded a point is, is the sum over its neighbors of `(1 - d / 2 r)^8`, with `r` half the
/// largest distance that `keep` points can all have from each other, and distances `d` that are
/// taken no less than a bound, so that near pairs do not count for more than crowds. Cost:
/// `n log n`.
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
    let crowd = |i: u32| neighbors.of(i).iter().map(|&j| weight(i, j)).sum();
    let mut crowds: Vec<f64> = (0..).take(points.len()).map(crowd).collect();
    // Every point is in the heap once, with what its sum was then; sums only fall. Those not
    // negative are in the order of their bits.
    let mut heap: BinaryHeap<(u64, u32)> = crowds.iter().map(|c| c.to_bits()).zip(0..).collect();
    let mut removed = Vec::with_capacity(points.len() - keep);
    while removed.len() + keep < points.len() {
        let Some((bits, point)) = heap.pop() else { break };
        let now = crowds[point as usize].to_bits();
        if bits != now {
            heap.push((now, point));
            continue;
        }
        removed.push(point);
        for &j in neighbors.of(point) {
            // Rounding does not make it negative.
            crowds[j as usize] = (crowds[j as usize] - weight(point, j)).max(0.0);
        }
    }
    removed
}
