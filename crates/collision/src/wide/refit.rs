//! Boxes fitted to where the segments are now.

use super::block::{Block, WIDTH};
use super::bounds::{Bounds, above, below};
use super::{Diagonals, Level, NONE};
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
        diagonals: &mut Diagonals,
        nodes: &[[u32; WIDTH]],
        frames: [&Capsules; N],
        margin: f64,
    ) {
        let blocks = self.blocks.par_chunks_mut(CHUNK).zip(self.hulls.par_chunks_mut(CHUNK));
        let Diagonals { blocks: oblique, hulls: around } = diagonals;
        let oblique = oblique.par_chunks_mut(CHUNK).zip(around.par_chunks_mut(CHUNK));
        let lanes = self.children.par_chunks(CHUNK).zip(nodes.par_chunks(CHUNK));
        blocks.zip(oblique).zip(lanes).for_each(|((along, oblique), (segments, nodes))| {
            Arch::new().dispatch(Fit { along, oblique, segments, nodes, frames, margin });
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
    along: (&'a mut [Block], &'a mut [Bounds]),
    oblique: (&'a mut [Block<6>], &'a mut [Bounds<6>]),
    segments: &'a [[u32; WIDTH]],
    nodes: &'a [[u32; WIDTH]],
    frames: [&'a Capsules<'a>; N],
    margin: f64,
}

impl<const N: usize> NullaryFnOnce for Fit<'_, N> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (b, (segments, nodes)) in self.segments.iter().zip(self.nodes).enumerate() {
            let ends = Ends::gather(segments, nodes, self.frames, self.margin);
            let (block, hull) = (&mut self.along.0[b], &mut self.along.1[b]);
            ends.fit(1.0, |[x, y, z]| [x, y, z], block, hull);
            let (oblique, around) = (&mut self.oblique.0[b], &mut self.oblique.1[b]);
            ends.fit(DIAGONAL, diagonals, oblique, around);
            for lane in (0..WIDTH).filter(|&lane| segments[lane] == NONE) {
                block.clear(lane);
                oblique.clear(lane);
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

    /// Encloses and rounds in all lanes at once, by coordinates in which lengths are so many times as large
    /// at most.
    #[inline(always)]
    fn fit<const D: usize>(
        &self,
        stretch: f64,
        coordinates: impl Fn([f64; 3]) -> [f64; D],
        block: &mut Block<D>,
        hull: &mut Bounds<D>,
    ) {
        let (mut low, mut high) = ([[f64::MAX; WIDTH]; D], [[f64::MIN; WIDTH]; D]);
        for ends in self.start.iter().chain(&self.end) {
            for lane in 0..WIDTH {
                let here = coordinates([ends[0][lane], ends[1][lane], ends[2][lane]]);
                for d in 0..D {
                    let (l, h) = (&mut low[d][lane], &mut high[d][lane]);
                    *l = if here[d] < *l { here[d] } else { *l };
                    *h = if here[d] > *h { here[d] } else { *h };
                }
            }
        }
        for d in 0..D {
            let mut negative = [0.0; WIDTH];
            for lane in 0..WIDTH {
                let grow = stretch * self.grow[lane];
                block.low[d][lane] = below(low[d][lane] - grow);
                block.high[d][lane] = above(high[d][lane] + grow);
                negative[lane] = -block.high[d][lane];
            }
            hull.low[d] = least(&block.low[d]);
            hull.high[d] = -least(&negative);
        }
    }
}

/// The length of `(1, 1, 0)`, rounded up.
const DIAGONAL: f64 = std::f64::consts::SQRT_2 * (1.0 + f64::EPSILON);

/// Coordinates along the diagonals of the axes' planes.
#[inline(always)]
fn diagonals([x, y, z]: [f64; 3]) -> [f64; 6] {
    [x + y, x - y, y + z, y - z, z + x, z - x]
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
