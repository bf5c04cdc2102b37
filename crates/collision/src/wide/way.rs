//! Pairs that may come near each other on a motion.

use super::Tree;
use super::lines::{MovingLine, sift, take_lines};
use crate::join::join;
use crate::narrow::squared_distances;
use crate::{Capsules, CollisionError, Pair};
use nalgebra::{Point3, Vector3};
use rapunzel_lanes::all_equal;
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
    /// Whether the tree holds what all segments sweep.
    is_in_tree: bool,
    /// Workspace: all segments.
    lines: Vec<MovingLine>,
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
        ways: &mut SegmentWays,
        pairs: &[Pair],
        [reach, slack]: [f64; 2],
    ) {
        ways.expect(pairs.len());
        let chunk = sieve(ways, reach + slack);
        join(pairs.par_chunks(WAY_CHUNK).map(chunk).collect(), &mut self.all);
        self.start.clear();
        self.start.extend_from_slice(start.positions());
        self.end.clear();
        self.end.extend_from_slice(end.positions());
        self.aside = 0.5 * slack;
        self.is_in_tree = false;
    }

    /// The same with those of all pairs that a tree finds.
    pub(super) fn set_out_among(
        &mut self,
        [start, end]: [&Capsules; 2],
        ways: &mut SegmentWays,
        tree: &mut Tree,
        [reach, slack]: [f64; 2],
    ) -> Result<(), CollisionError> {
        tree.refit_swept(start, end, 0.5 * (reach + slack))?;
        let mut pairs = Vec::new();
        take_lines(start, end, reach + slack, &mut self.lines);
        let lines = &self.lines;
        let sifted = |pairs: &mut Vec<Pair>| {
            sift(lines, pairs);
            pairs.clone()
        };
        tree.sifted_pairs(sifted, &mut pairs);
        self.set_out([start, end], ways, &pairs, [reach, slack]);
        self.is_in_tree = true;
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
        if self.is_in_tree {
            tree.refit_swept_of(&turned, start, &end, 0.5 * reach)?;
        } else {
            tree.refit_swept(start, &end, 0.5 * reach)?;
            self.is_in_tree = true;
        }
        let mut found = Vec::new();
        let ways = SegmentWays::new(start, &end, Vec::new());
        let near = sieve(&ways, reach);
        tree.sifted_pairs_of(&turned, |pairs| near(pairs), &mut found);
        self.all.retain(|(pair, _)| pair.iter().all(|&segment| !turned[segment as usize]));
        self.all.append(&mut found);
        Ok(())
    }

    /// Notes that the tree is fitted to something else.
    pub(super) fn leave_tree(&mut self) {
        self.is_in_tree = false;
    }

    /// Which ends of a motion are not those that it has set out for; `None` where all may be
    /// others.
    pub(super) fn astray(&self, start: &Capsules, end: &Capsules) -> Option<Astray> {
        if !all_equal(&self.start, start.positions(), |p| p.coords.into()) {
            return None;
        }
        let ends = || self.end.iter().zip(end.positions());
        // What all do alike brings none nearer to another.
        let sum: Vector3<f64> = ends().map(|(a, b)| b - a).sum();
        let shift = sum / self.end.len().max(1) as f64;
        let most = self.aside * self.aside;
        let far = |(_, (a, b)): &(usize, (&Point3<f64>, &Point3<f64>))| {
            (*b - *a - shift).norm_squared() > most
        };
        let nodes: Vec<_> = ends().enumerate().filter(far).map(|(node, _)| node).collect();
        (FEW_WAYS * nodes.len() <= self.end.len()).then_some(Astray { nodes, shift })
    }

    /// Finds the pairs that may come within `reach`, m, of each other on their `ways`.
    pub(super) fn go(&self, ways: &mut SegmentWays, reach: f64) -> Vec<(Pair, f64)> {
        ways.expect(self.all.len());
        let ways = &*ways;
        let chunk = |pairs: &[(Pair, f64)]| {
            let mut found = Vec::with_capacity(pairs.len());
            let near = pairs.iter().filter(|(pair, squared)| ways.near(pair, *squared, reach));
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
fn sieve<'a>(
    ways: &'a SegmentWays<'a>,
    reach: f64,
) -> impl Fn(&[Pair]) -> Vec<(Pair, f64)> + Sync + Send + 'a {
    move |pairs| {
        let (mut squared, mut found) = (Vec::new(), Vec::with_capacity(pairs.len()));
        squared_distances(ways.start, pairs, &mut squared);
        let both = pairs.iter().copied().zip(squared);
        found.extend(both.filter(|(pair, squared)| ways.near(pair, *squared, reach)));
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

/// The ways of all segments between two places: in a table where they are asked for often, else
/// found each time.
pub(super) struct SegmentWays<'a> {
    start: &'a Capsules<'a>,
    end: &'a Capsules<'a>,
    table: Vec<OneWay>,
}

impl<'a> SegmentWays<'a> {
    /// The ways from `start` to `end`; `room` is what a table takes.
    pub(super) fn new(
        start: &'a Capsules<'a>,
        end: &'a Capsules<'a>,
        mut room: Vec<OneWay>,
    ) -> Self {
        room.clear();
        Self { start, end, table: room }
    }

    /// Makes the table if the ways of so many pairs are worth it.
    fn expect(&mut self, pairs: usize) {
        if self.table.is_empty() && 2 * pairs > self.start.len() {
            let mut table = std::mem::take(&mut self.table);
            let all = (0..self.start.len()).into_par_iter();
            all.map(|segment| self.find(segment)).collect_into_vec(&mut table);
            self.table = table;
        }
    }

    fn find(&self, segment: usize) -> OneWay {
        let [i, j] = self.start.layout().segment_nodes(segment);
        let (start, end) = (self.start.positions(), self.end.positions());
        let (a, b) = (end[i] - start[i], end[j] - start[j]);
        let own = 0.5 * (a - b).norm() + self.start.radii()[segment];
        OneWay { middle: 0.5 * (a + b), own }
    }

    /// The room of the table.
    pub(super) fn into_room(self) -> Vec<OneWay> {
        self.table
    }

    /// Whether a pair at a squared distance, m², at the start may come within `reach`, m, on its
    /// ways.
    fn near(&self, pair: &Pair, squared: f64, reach: f64) -> bool {
        let both = |a: &OneWay, b: &OneWay| {
            // The fast distances may be off by roundings.
            let far = ((a.middle - b.middle).norm() + a.own + b.own + reach) * (1.0 + 1e-6);
            squared <= far * far
        };
        let (a, b) = (pair[0] as usize, pair[1] as usize);
        if self.table.is_empty() {
            both(&self.find(a), &self.find(b))
        } else {
            both(&self.table[a], &self.table[b])
        }
    }
}
