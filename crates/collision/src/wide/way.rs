//! Pairs that may come near each other on a motion.

use crate::narrow::squared_distances;
use crate::{Capsules, Pair};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Pairs that one task takes.
const CHUNK: usize = 4096;

/// Pairs of motions from one start, and how far they were apart there.
#[derive(Debug, Clone, Default)]
pub(super) struct Way {
    start: Vec<Point3<f64>>,
    /// The end of the motion whose pairs were searched for; none if they are those of a list.
    end: Option<Vec<Point3<f64>>>,
    all: Vec<Pair>,
    /// Of all pairs at the start, m².
    squared: Vec<f64>,
    /// Of the last motion.
    pub(super) near: Vec<Pair>,
}

impl Way {
    /// Sets out with pairs from a start, found for one `end` if any.
    pub(super) fn new(start: &Capsules, end: Option<&Capsules>, all: Vec<Pair>) -> Self {
        let chunk = |pairs: &[Pair]| {
            let mut squared = Vec::new();
            squared_distances(start, pairs, &mut squared);
            squared
        };
        let squared: Vec<_> = all.par_chunks(CHUNK).map(chunk).collect();
        Self {
            start: start.positions().to_vec(),
            end: end.map(|end| end.positions().to_vec()),
            all,
            squared: squared.concat(),
            near: Vec::new(),
        }
    }

    /// Whether the pairs are those of a list, from this start.
    pub(super) fn listed(&self, start: &Capsules) -> bool {
        self.end.is_none() && self.start == start.positions()
    }

    /// Whether the pairs were searched for a motion from this start to this end, but for half of
    /// `slack`, m.
    pub(super) fn leads(&self, start: &Capsules, end: &Capsules, slack: f64) -> bool {
        let near = |(a, b): (&Point3<f64>, &Point3<f64>)| (a - b).norm() <= 0.5 * slack;
        let Some(points) = &self.end else { return false };
        self.start == start.positions() && points.iter().zip(end.positions()).all(near)
    }

    /// Finds the pairs that may come within `reach`, m, of each other until `end`.
    pub(super) fn go(&mut self, start: &Capsules, end: &Capsules, reach: f64) {
        let travels: Vec<_> = (0..start.len()).map(|segment| travel(start, end, segment)).collect();
        let near = |(pair, squared): &(&Pair, &f64)| {
            let [i, j] = pair.map(|segment| segment as usize);
            let travel = (travels[i].0 - travels[j].0).norm() + travels[i].1 + travels[j].1;
            let far = reach + start.radii()[i] + start.radii()[j] + travel;
            // The fast distances may be off by roundings.
            **squared <= (far * (1.0 + 1e-6)).powi(2)
        };
        let chunk = |(pairs, squared): (&[Pair], &[f64])| {
            pairs.iter().zip(squared).filter(near).map(|(pair, _)| *pair).collect()
        };
        let chunks = self.all.par_chunks(CHUNK).zip(self.squared.par_chunks(CHUNK));
        let parts: Vec<Vec<Pair>> = chunks.map(chunk).collect();
        self.near = parts.concat();
    }
}

/// The way of the middle of a segment, and how much farther another of its points may go, m.
fn travel(start: &Capsules, end: &Capsules, segment: usize) -> (Vector3<f64>, f64) {
    let nodes = start.layout().segment_nodes(segment);
    let [a, b] = nodes.map(|node| end.positions()[node] - start.positions()[node]);
    (0.5 * (a + b), 0.5 * (a - b).norm())
}
