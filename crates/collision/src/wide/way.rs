//! Pairs that may come near each other on a motion.

use super::Tree;
use super::lines::{lines, sift};
use crate::join::join;
use crate::narrow::squared_distances;
use crate::{Capsules, CollisionError, Pair};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Pairs that one task takes.
const WAY_CHUNK: usize = 4096;

/// Where at least one of so many ends is astray, a search for all is hardly more.
const FEW_WAYS: usize = 8;

/// Pairs of motions from one start, and how far they were apart there.
#[derive(Debug, Clone, Default)]
pub(super) struct Way {
    start: Vec<Point3<f64>>,
    end: Vec<Point3<f64>>,
    /// By how much an end may be elsewhere, m, beside what all have in common.
    aside: f64,
    /// All pairs, and their squared distances at the start, m².
    all: Vec<(Pair, f64)>,
}

/// Ends of a motion that are not those that were expected.
#[derive(Debug)]
pub(super) struct Astray {
    pub(super) nodes: Vec<usize>,
    /// By how much all are elsewhere, m.
    shift: Vector3<f64>,
}

impl Way {
    /// Sets out with those of `pairs` that may come within `reach`, m, of each other on the way to
    /// `end`, or to an end that is elsewhere by half of `slack`, m.
    pub(super) fn set_out(
        &mut self,
        [start, end]: [&Capsules; 2],
        ways: &[OneWay],
        pairs: &[Pair],
        [reach, slack]: [f64; 2],
    ) {
        let chunk = sieve(start, ways, reach + slack);
        join(pairs.par_chunks(WAY_CHUNK).map(chunk).collect(), &mut self.all);
        self.start.clear();
        self.start.extend_from_slice(start.positions());
        self.end.clear();
        self.end.extend_from_slice(end.positions());
        self.aside = 0.5 * slack;
    }

    /// The same with those of all pairs that a tree finds.
    pub(super) fn set_out_among(
        &mut self,
        [start, end]: [&Capsules; 2],
        ways: &[OneWay],
        tree: &mut Tree,
        [reach, slack]: [f64; 2],
    ) -> Result<(), CollisionError> {
        tree.refit_swept(start, end, 0.5 * (reach + slack))?;
        let mut pairs = Vec::new();
        let lines = lines(start, end, reach + slack);
        let sifted = |pairs: &mut Vec<Pair>| {
            sift(&lines, pairs);
            pairs.clone()
        };
        tree.sifted_pairs(sifted, &mut pairs);
        // They are large, and no more needed.
        drop(lines);
        self.set_out([start, end], ways, &pairs, [reach, slack]);
        Ok(())
    }

    /// Turns the ends of a motion that are `astray` to where they are now, with those pairs of
    /// their segments that a tree finds.
    pub(super) fn turn(
        &mut self,
        start: &Capsules,
        end: &Capsules,
        astray: &Astray,
        tree: &mut Tree,
        reach: f64,
    ) -> Result<(), CollisionError> {
        for &node in &astray.nodes {
            self.end[node] = end.positions()[node] - astray.shift;
        }
        let mut turned = vec![false; start.len()];
        let layout = start.layout();
        let mut is_astray = vec![false; layout.nodes()];
        astray.nodes.iter().for_each(|&node| is_astray[node] = true);
        for (segment, turned) in turned.iter_mut().enumerate() {
            *turned = layout.segment_nodes(segment).iter().any(|&node| is_astray[node]);
        }
        let reach = reach + 2.0 * self.aside;
        let end = Capsules::new(layout, &self.end, start.radii())?;
        tree.refit_swept(start, &end, 0.5 * reach)?;
        let mut found = Vec::new();
        let mut ways = Vec::new();
        take_ways(start, &end, &mut ways);
        let near = sieve(start, &ways, reach);
        tree.sifted_pairs_of(&turned, |pairs| near(pairs), &mut found);
        self.all.retain(|(pair, _)| pair.iter().all(|&segment| !turned[segment as usize]));
        self.all.append(&mut found);
        Ok(())
    }

    /// Which ends of a motion are not those that it has set out for; `None` where all may be
    /// others.
    pub(super) fn astray(&self, start: &Capsules, end: &Capsules) -> Option<Astray> {
        if self.start != start.positions() {
            return None;
        }
        let ends = || self.end.iter().zip(end.positions());
        // What all do alike brings none nearer to another.
        let sum: Vector3<f64> = ends().map(|(a, b)| b - a).sum();
        let shift = sum / self.end.len().max(1) as f64;
        let far = |(_, (a, b)): &(usize, (&Point3<f64>, &Point3<f64>))| {
            (*b - *a - shift).norm() > self.aside
        };
        let nodes: Vec<_> = ends().enumerate().filter(far).map(|(node, _)| node).collect();
        (FEW_WAYS * nodes.len() <= self.end.len()).then_some(Astray { nodes, shift })
    }

    /// Finds the pairs that may come within `reach`, m, of each other on their `ways`.
    pub(super) fn go(&self, ways: &[OneWay], reach: f64) -> Vec<(Pair, f64)> {
        let chunk = |pairs: &[(Pair, f64)]| {
            let mut found = Vec::with_capacity(pairs.len());
            let near = pairs.iter().filter(|(pair, squared)| near(ways, pair, *squared, reach));
            found.extend(near);
            found
        };
        let mut found = Vec::new();
        join(self.all.par_chunks(WAY_CHUNK).map(chunk).collect(), &mut found);
        found
    }
}

/// Those of some pairs that may come within `reach`, m, of each other on their ways, with their
/// squared distances at the start, m².
fn sieve(
    start: &Capsules,
    ways: &[OneWay],
    reach: f64,
) -> impl Fn(&[Pair]) -> Vec<(Pair, f64)> + Sync + Send {
    move |pairs| {
        let (mut squared, mut found) = (Vec::new(), Vec::with_capacity(pairs.len()));
        squared_distances(start, pairs, &mut squared);
        let both = pairs.iter().copied().zip(squared);
        found.extend(both.filter(|(pair, squared)| near(ways, pair, *squared, reach)));
        found
    }
}

/// The way of one segment.
#[derive(Debug, Clone)]
pub(super) struct OneWay {
    /// Of its middle, m.
    middle: Vector3<f64>,
    /// How far another of its points may go beyond that, m, and its radius.
    own: f64,
}

/// Replaces `ways` by those of all segments.
pub(super) fn take_ways(start: &Capsules, end: &Capsules, ways: &mut Vec<OneWay>) {
    let way = |segment| {
        let nodes = start.layout().segment_nodes(segment);
        let [a, b] = nodes.map(|node| end.positions()[node] - start.positions()[node]);
        let own = 0.5 * (a - b).norm() + start.radii()[segment];
        OneWay { middle: 0.5 * (a + b), own }
    };
    (0..start.len()).into_par_iter().map(way).collect_into_vec(ways);
}

/// Whether a pair at a squared distance, m², at the start may come within `reach`, m, on its ways.
fn near(ways: &[OneWay], pair: &Pair, squared: f64, reach: f64) -> bool {
    let [a, b] = pair.map(|segment| &ways[segment as usize]);
    // The fast distances may be off by roundings.
    let far = ((a.middle - b.middle).norm() + a.own + b.own + reach) * (1.0 + 1e-6);
    squared <= far * far
}
