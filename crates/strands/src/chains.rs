//! Edges between points as polylines.

use crate::StrandFault;
use crate::raw::RawStrands;
use nalgebra::Point3;

/// Joins edges that share points to strands, in the order of their least points.
///
/// The root of a strand is its end of the lower number; points without an edge belong to no strand.
/// All ends of edges are points, and `widths` are empty or as many as the points. Cost: a sort of
/// the edges.
pub(crate) fn joined(edges: &[[u32; 2]], points: &[Point3<f64>], widths: &[f64]) -> RawStrands {
    let mut raw = RawStrands::default();
    let around = ChainNeighbors::new(edges, points.len());
    let mut seen = vec![false; points.len()];
    for start in 0..points.len() {
        if seen[start] || around.of(start).is_empty() {
            continue;
        }
        // All points that hang together with this one.
        let mut members = vec![start];
        seen[start] = true;
        let mut next = 0;
        while let Some(&point) = members.get(next) {
            next += 1;
            for other in around.of(point).iter().map(|&p| p as usize) {
                if !std::mem::replace(&mut seen[other], true) {
                    members.push(other);
                }
            }
        }
        let degree = |p: &usize| around.of(*p).len();
        let root = members.iter().filter(|p| degree(p) == 1).min();
        let fault = match root {
            _ if members.iter().any(|p| degree(p) > 2) => StrandFault::Branch,
            None => StrandFault::Ring,
            Some(&root) => {
                raw.counts.push(members.len());
                for point in around.walk(root) {
                    raw.points.push(points[point]);
                    raw.widths.extend(widths.get(point));
                }
                continue;
            }
        };
        raw.faults.push((raw.counts.len(), fault));
        raw.counts.push(0);
    }
    raw
}

/// The points at the other ends of the edges of every point.
struct ChainNeighbors {
    starts: Vec<usize>,
    points: Vec<u32>,
}

impl ChainNeighbors {
    fn new(edges: &[[u32; 2]], count: usize) -> Self {
        let both = edges.iter().flat_map(|&[a, b]| [[a, b], [b, a]]);
        let mut sides: Vec<_> = both.filter(|[a, b]| a != b).collect();
        sides.sort_unstable();
        sides.dedup();
        let mut starts = vec![0; count + 1];
        for &[from, _] in &sides {
            starts[from as usize + 1] += 1;
        }
        for point in 0..count {
            starts[point + 1] += starts[point];
        }
        Self { starts, points: sides.into_iter().map(|[_, to]| to).collect() }
    }

    fn of(&self, point: usize) -> &[u32] {
        &self.points[self.starts[point]..self.starts[point + 1]]
    }

    /// The points along a chain from its end `root` on.
    fn walk(&self, root: usize) -> impl Iterator<Item = usize> {
        let mut previous = root;
        std::iter::successors(Some(root), move |&point| {
            let next = self.of(point).iter().map(|&p| p as usize).find(|&p| p != previous);
            previous = point;
            next
        })
    }
}
