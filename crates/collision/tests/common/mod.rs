//! What the tests of searches share: answers that no tree gave, and data.
#![allow(dead_code, reason = "each test takes what it needs")]

use nalgebra::Vector3;
use rapunzel_collision::{Capsule, Capsules, Pair};
use std::io::Write;
use std::path::PathBuf;

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

/// Whether sorted pairs are those that a tree finds: all that must be, and none that would not be with radii
/// larger by its `rounding`, m.
pub(crate) fn are_tree_pairs(found: &[Pair], capsules: &Capsules, rounding: f64) -> bool {
    let radii: Vec<_> = capsules.radii().iter().map(|r| r + rounding).collect();
    let wide = Capsules::new(capsules.layout(), capsules.positions(), &radii).expect("valid");
    let allowed = tree_pairs(&wide);
    tree_pairs(capsules).iter().all(|pair| found.binary_search(pair).is_ok())
        && found.iter().all(|pair| allowed.binary_search(pair).is_ok())
}

/// Of the pairs whose boxes overlap those that also do along the diagonals of the axes' planes.
pub(crate) fn tree_pairs(capsules: &Capsules) -> Vec<Pair> {
    let diagonals = [[1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]].map(Vector3::from);
    let others = [[1.0, -1.0, 0.0], [0.0, 1.0, -1.0], [-1.0, 0.0, 1.0]].map(Vector3::from);
    let extent = |segment: u32, along: &Vector3<f64>| {
        let Capsule { start, end, radius } = capsules.get(segment as usize);
        let (a, b) = (along.dot(&start.coords), along.dot(&end.coords));
        let radius = 2.0_f64.sqrt() * radius;
        [a.min(b) - radius, a.max(b) + radius]
    };
    let overlap = |pair: &Pair| {
        diagonals.iter().chain(&others).all(|along| {
            let [[low, high], [other_low, other_high]] = pair.map(|s| extent(s, along));
            low <= other_high && other_low <= high
        })
    };
    let mut pairs = box_pairs(capsules);
    pairs.retain(overlap);
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

/// A folder of the data that is not shipped: in `RAPUNZEL_DATA`, else beside the repository.
pub(crate) fn data(folder: &str) -> Option<PathBuf> {
    let beside = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data"));
    let path = std::env::var_os("RAPUNZEL_DATA").map_or_else(beside, PathBuf::from).join(folder);
    if path.exists() {
        return Some(path);
    }
    // Past the capture of the test runner: nobody shall take a skipped test for one that passed.
    let told = writeln!(
        std::io::stderr(),
        "SKIPPED: there is no {}; set RAPUNZEL_DATA to the folder that holds it",
        path.display()
    );
    told.expect("standard error is open");
    None
}
