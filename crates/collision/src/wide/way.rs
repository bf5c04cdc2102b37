//! Pairs that may come near each other on a motion.

use super::Tree;
use super::lines::{lines, sift};
use super::pairs::join;
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
    end: Vec<Point3<f64>>,
    /// By how much an end may be elsewhere, m.
    aside: f64,
    /// All pairs, and their squared distances at the start, m².
    all: Vec<(Pair, f64)>,
    /// Of the last motion.
    pub(super) near: Vec<Pair>,
}

impl Way {
    /// Sets out with those of `pairs` that may come within `reach`, m, of each other on the way to
    /// `end`, or to an end that is elsewhere by half of `slack`, m.
    pub(super) fn set_out(
        &mut self,
        start: &Capsules,
        end: &Capsules,
        pairs: &[Pair],
        [reach, slack]: [f64; 2],
    ) {
        let chunk = sieve(start, end, reach + slack);
        join(pairs.par_chunks(CHUNK).map(chunk).collect(), &mut self.all);
        self.start.clear();
        self.start.extend_from_slice(start.positions());
        self.end.clear();
        self.end.extend_from_slice(end.positions());
        self.aside = 0.5 * slack;
    }

    /// The same with those of all pairs that a tree finds.
    pub(super) fn set_out_among(
        &mut self,
        start: &Capsules,
        end: &Capsules,
        tree: &Tree,
        [reach, slack]: [f64; 2],
    ) {
        let mut pairs = Vec::new();
        let lines = lines(start, end, reach + slack);
        let sifted = |pairs: &mut Vec<Pair>| {
            sift(&lines, pairs);
            pairs.clone()
        };
        tree.sifted_pairs(sifted, &mut pairs);
        // They are large, and no more needed.
        drop(lines);
        self.set_out(start, end, &pairs, [reach, slack]);
    }

    /// Whether a motion is one of those that it has set out for.
    pub(super) fn leads(&self, start: &Capsules, end: &Capsules) -> bool {
        let near = |(a, b): (&Point3<f64>, &Point3<f64>)| (a - b).norm() <= self.aside;
        self.start == start.positions() && self.end.iter().zip(end.positions()).all(near)
    }

    /// Finds the pairs that may come within `reach`, m, of each other until `end`.
    pub(super) fn go(&mut self, start: &Capsules, end: &Capsules, reach: f64) {
        let near = near(start, end, reach);
        let chunk = |pairs: &[(Pair, f64)]| {
            let here = pairs.iter().filter(|(pair, squared)| near(pair, *squared));
            here.map(|(pair, _)| *pair).collect()
        };
        join(self.all.par_chunks(CHUNK).map(chunk).collect(), &mut self.near);
    }
}

/// Those of some pairs that may come within `reach`, m, of each other until `end`, with their squared
/// distances at the start, m².
fn sieve(
    start: &Capsules,
    end: &Capsules,
    reach: f64,
) -> impl Fn(&[Pair]) -> Vec<(Pair, f64)> + Sync + Send {
    let near = near(start, end, reach);
    move |pairs| {
        let mut squared = Vec::new();
        squared_distances(start, pairs, &mut squared);
        let both = pairs.iter().copied().zip(squared);
        both.filter(|(pair, squared)| near(pair, *squared)).collect()
    }
}

/// Whether a pair at a squared distance, m², at the start may come within `reach`, m, until the end.
fn near(start: &Capsules, end: &Capsules, reach: f64) -> impl Fn(&Pair, f64) -> bool + Sync + Send {
    // The way of the middle of each segment, and how far another of its points may go beyond it and
    // the reach, its own part.
    let ways: Vec<[f64; 4]> = (0..start.len())
        .into_par_iter()
        .map(|segment| {
            let nodes = start.layout().segment_nodes(segment);
            let [a, b] = nodes.map(|node| end.positions()[node] - start.positions()[node]);
            let middle = 0.5 * (a + b);
            let own = 0.5 * (a - b).norm() + start.radii()[segment] + 0.5 * reach;
            [middle.x, middle.y, middle.z, own]
        })
        .collect();
    move |pair, squared| {
        let [a, b] = pair.map(|segment| ways[segment as usize]);
        let apart = Vector3::new(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
        // The fast distances may be off by roundings.
        let far = (apart.norm() + a[3] + b[3]) * (1.0 + 1e-6);
        squared <= far * far
    }
}
