//! Boxes fitted to where the segments are now.

use super::block::{Block, WIDTH};
use super::bounds::{Bounds, above, below};
use super::{Level, NONE};
use crate::Capsules;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// Blocks that one thread fits at a time.
const CHUNK: usize = 64;

impl Level {
    /// Fits the boxes of the lowest level to segments that are grown by `margin`, m; `nodes` are
    /// the first nodes of the segments in the lanes.
    pub(super) fn fit_segments(
        &mut self,
        nodes: &[[u32; WIDTH]],
        capsules: &Capsules,
        margin: f64,
    ) {
        let blocks = self.blocks.par_chunks_mut(CHUNK).zip(self.hulls.par_chunks_mut(CHUNK));
        let lanes = self.children.par_chunks(CHUNK).zip(nodes.par_chunks(CHUNK));
        blocks.zip(lanes).for_each(|((blocks, hulls), (segments, nodes))| {
            Arch::new().dispatch(Fit { blocks, hulls, segments, nodes, capsules, margin });
        });
    }

    /// Fits the boxes of a higher level to the hulls of the blocks below.
    pub(super) fn fit_hulls(&mut self, below: &[Bounds]) {
        let blocks = self.blocks.par_chunks_mut(CHUNK).zip(self.hulls.par_chunks_mut(CHUNK));
        blocks.zip(self.children.par_chunks(CHUNK)).for_each(|((blocks, hulls), children)| {
            for ((block, hull), children) in blocks.iter_mut().zip(hulls).zip(children) {
                *hull = Bounds::EMPTY;
                for (lane, &child) in children.iter().enumerate().take_while(|(_, c)| **c != NONE) {
                    block.set(lane, &below[child as usize]);
                    hull.hold(&below[child as usize]);
                }
            }
        });
    }
}

struct Fit<'a> {
    blocks: &'a mut [Block],
    hulls: &'a mut [Bounds],
    segments: &'a [[u32; WIDTH]],
    nodes: &'a [[u32; WIDTH]],
    capsules: &'a Capsules<'a>,
    margin: f64,
}

impl NullaryFnOnce for Fit<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for b in 0..self.blocks.len() {
            let (segments, nodes) = (&self.segments[b], &self.nodes[b]);
            let (block, hull) = (&mut self.blocks[b], &mut self.hulls[b]);
            fit(block, hull, segments, nodes, self.capsules, self.margin);
        }
    }
}

/// Fits one block. Segments are gathered lane by lane, everything else is done in all lanes at
/// once; lanes without a segment repeat the first and are emptied at the end.
#[inline(always)]
fn fit(
    block: &mut Block,
    hull: &mut Bounds,
    segments: &[u32; WIDTH],
    nodes: &[u32; WIDTH],
    capsules: &Capsules,
    margin: f64,
) {
    let (positions, radii) = (capsules.positions(), capsules.radii());
    let (mut p, mut q) = ([[0.0; WIDTH]; 3], [[0.0; WIDTH]; 3]);
    let mut grow = [0.0; WIDTH];
    for lane in 0..WIDTH {
        let used = if segments[lane] == NONE { 0 } else { lane };
        let node = nodes[used] as usize;
        let (start, end) = (&positions[node], &positions[node + 1]);
        for d in 0..3 {
            p[d][lane] = start[d];
            q[d][lane] = end[d];
        }
        grow[lane] = radii[segments[used] as usize] + margin;
    }
    for d in 0..3 {
        for lane in 0..WIDTH {
            let (p, q) = (p[d][lane], q[d][lane]);
            block.low[d][lane] = below(if p < q { p } else { q } - grow[lane]);
            block.high[d][lane] = above(if p > q { p } else { q } + grow[lane]);
        }
        hull.low[d] = least(&block.low[d]);
        hull.high[d] = -least(&block.high[d].map(|x| -x));
    }
    for lane in 0..WIDTH {
        if segments[lane] == NONE {
            block.clear(lane);
        }
    }
}

/// The least of sixteen numbers, by halves.
#[inline(always)]
fn least(x: &[f32; WIDTH]) -> f32 {
    let mut x = *x;
    let mut half = WIDTH / 2;
    while half > 0 {
        for lane in 0..half {
            let other = x[lane + half];
            x[lane] = if other < x[lane] { other } else { x[lane] };
        }
        half /= 2;
    }
    x[0]
}
