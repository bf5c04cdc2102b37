//! What the tests of searches share: answers that no tree gave, and data.

use nalgebra::Vector3;
use rapunzel_collision::{Capsule, Capsules, Pair};

/// All pairs that are not adjacent and whose axis-aligned boxes overlap (closed), sorted: by a
/// sweep along z, independent of every tree.
pub(crate) fn box_pairs(capsules: &Capsules) -> Vec<Pair> {
    let boxes: Vec<_> = (0..capsules.len()).map(|s| bounds(&capsules.get(s))).collect();
    let mut order: Vec<u32> = (0..).take(boxes.len()).collect();
    order.sort_by(|&i, &j| boxes[i as usize].0.z.total_cmp(&boxes[j as usize].0.z));
    let mut pairs = Vec::new();
    for (k, &i) in order.iter().enumerate() {
        let (low, high) = &boxes[i as usize];
        for &j in &order[k + 1..] {
            let (other_low, other_high) = &boxes[j as usize];
            if other_low.z > high.z {
                break;
            }
            let overlap = (0..2).all(|d| low[d] <= other_high[d] && other_low[d] <= high[d]);
            if overlap && !capsules.adjacent(i as usize, j as usize) {
                pairs.push([i.min(j), i.max(j)]);
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

/// Two segments as a pair.
pub(crate) fn pair(i: usize, j: usize) -> Pair {
    [i, j].map(|s| u32::try_from(s).expect("few segments"))
}

/// The smallest box that holds a capsule: its low and its high corner.
pub(crate) fn bounds(capsule: &Capsule) -> (Vector3<f64>, Vector3<f64>) {
    let (a, b) = (capsule.start.coords, capsule.end.coords);
    let radius = Vector3::repeat(capsule.radius);
    (a.inf(&b) - radius, a.sup(&b) + radius)
}
