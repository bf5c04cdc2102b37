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
    /// Fits the boxes of the lowest level to the segments of all `frames`, grown by `margin`, m;
    /// `nodes` are the first nodes of the segments in the lanes.
    pub(super) fn fit_segments<const N: usize>(
        &mut self,
        nodes: &[[u32; WIDTH]],
        frames: [&Capsules; N],
        margin: f64,
    ) {
        let blocks = self.blocks.par_chunks_mut(CHUNK).zip(self.hulls.par_chunks_mut(CHUNK));
        let lanes = self.children.par_chunks(CHUNK).zip(nodes.par_chunks(CHUNK));
        blocks.zip(lanes).for_each(|((blocks, hulls), (segments, nodes))| {
            Arch::new().dispatch(Fit { blocks, hulls, segments, nodes, frames, margin });
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

struct Fit<'a, const N: usize> {
    blocks: &'a mut [Block],
    hulls: &'a mut [Bounds],
    segments: &'a [[u32; WIDTH]],
    nodes: &'a [[u32; WIDTH]],
    frames: [&'a Capsules<'a>; N],
    margin: f64,
}

impl<const N: usize> NullaryFnOnce for Fit<'_, N> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for b in 0..self.blocks.len() {
            let (segments, nodes) = (&self.segments[b], &self.nodes[b]);
            let (block, hull) = (&mut self.blocks[b], &mut self.hulls[b]);
            let ends = Ends::gather(segments, nodes, self.frames, self.margin);
            ends.fit(block, hull);
            for lane in 0..WIDTH {
                if segments[lane] == NONE {
                    block.clear(lane);
                }
            }
        }
    }
}

/// Ends of the segments in the lanes of a block in every frame, and by how much boxes are larger
/// than axes, m.
struct Ends<const N: usize> {
    start: [[[f64; WIDTH]; 3]; N],
    end: [[[f64; WIDTH]; 3]; N],
    grow: [f64; WIDTH],
}

impl<const N: usize> Ends<N> {
    /// Gathers segment by segment; lanes without one repeat the first.
    #[inline(always)]
    fn gather(
        segments: &[u32; WIDTH],
        nodes: &[u32; WIDTH],
        frames: [&Capsules; N],
        margin: f64,
    ) -> Self {
        let zero = [[[0.0; WIDTH]; 3]; N];
        let mut ends = Self { start: zero, end: zero, grow: [0.0; WIDTH] };
        for lane in 0..WIDTH {
            let used = if segments[lane] == NONE { 0 } else { lane };
            let node = nodes[used] as usize;
            for k in 0..N {
                let positions = frames[k].positions();
                for d in 0..3 {
                    ends.start[k][d][lane] = positions[node][d];
                    ends.end[k][d][lane] = positions[node + 1][d];
                }
            }
            ends.grow[lane] = frames[0].radii()[segments[used] as usize] + margin;
        }
        ends
    }

    /// Encloses and rounds in all lanes at once.
    #[inline(always)]
    fn fit(&self, block: &mut Block, hull: &mut Bounds) {
        for d in 0..3 {
            for lane in 0..WIDTH {
                let (p, q) = (self.start[0][d][lane], self.end[0][d][lane]);
                let (mut low, mut high) = (if p < q { p } else { q }, if p > q { p } else { q });
                for k in 1..N {
                    for x in [self.start[k][d][lane], self.end[k][d][lane]] {
                        low = if x < low { x } else { low };
                        high = if x > high { x } else { high };
                    }
                }
                block.low[d][lane] = below(low - self.grow[lane]);
                block.high[d][lane] = above(high + self.grow[lane]);
            }
            hull.low[d] = least(&block.low[d]);
            let mut negative = [0.0; WIDTH];
            for lane in 0..WIDTH {
                negative[lane] = -block.high[d][lane];
            }
            hull.high[d] = -least(&negative);
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
